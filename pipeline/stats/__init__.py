"""Floor 1: statistics on NumPy and SciPy: a scene's results, their errors, ranks and verdicts."""
