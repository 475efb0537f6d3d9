"""`./run python -m benchmarks.aa`: a real A/A, one view under two names whose repeats share no draw.

The first half of a branch's repeats is taken for one view and the second half for another. Nothing is
common to them, so the interval is that of the two-sample t-test with equal variances.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy import stats

from pipeline.contract.artefacts import read_json


def main() -> None:
    """Prints the difference of the halves with its 95 % interval, which holds zero in 19 cases of 20."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scene", required=True)
    parser.add_argument("--branch", required=True)
    chosen = parser.parse_args()
    path = Path("reports/branches", chosen.scene, chosen.branch, "evaluation.json")
    returns = np.array([row["return"] for row in read_json(path, f"evaluation@{chosen.branch}")["repeats"]])
    if len(returns) < 4:
        parser.error(f"{path} has {len(returns)} repeats; an A/A takes 4 or more")
    first, second = np.array_split(returns, 2)
    found = stats.ttest_ind(first, second)
    low, high = found.confidence_interval(0.95)
    gap = first.mean() - second.mean()
    print(f"{len(first)} repeats: {first.mean():.3f} m; the other {len(second)}: {second.mean():.3f} m")
    print(f"difference {gap:.3f} m [{low:.3f}, {high:.3f}], p = {found.pvalue:.3f}")


if __name__ == "__main__":
    main()
