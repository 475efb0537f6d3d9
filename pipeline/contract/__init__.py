"""Floor 0: what the stages agree on. Parameters, artefact layouts, seeds, errors, the stage entry."""
