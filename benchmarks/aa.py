"""`./run python -m benchmarks.aa`: two A/A checks on the results at hand.

Without flags, simulated: of each scene's ranked table the residuals are drawn again into tables whose views
are all alike; the share in which some interval of a difference leaves out zero should be near 5 %.

With ``--scene`` and ``--branch``, real: the first half of the branch's repeats is taken for one view and the
second half for another. Nothing is common to them, so the interval is that of the two-sample t-test.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from scipy import stats

from pipeline.contract import params
from pipeline.contract.artefacts import read_json
from pipeline.stats.branches import read_results
from pipeline.stats.coverage import resampled, residuals

TABLES, CONFIDENCE, SEED = 5000, 0.95, 1


def simulated(scene: str) -> str:
    """False positives among tables drawn from the residuals of a scene's scores."""
    results = read_results(scene, Path("reports/branches", scene), Path("reports/anchors", f"{scene}.json"))
    left = residuals(results.scores)
    found = resampled(left, TABLES, CONFIDENCE, np.random.default_rng(SEED))
    views, repeats = left.shape
    return f"{scene}: {views} views, {repeats} repeats: {1 - found.differences:.1%} of {TABLES} tables"


def real(path: Path, returns: np.ndarray) -> str:
    """The difference of a branch's two halves with its interval, which holds zero in 19 cases of 20."""
    first, second = np.array_split(returns, 2)
    found = stats.ttest_ind(first, second)
    low, high = found.confidence_interval(CONFIDENCE)
    gap = first.mean() - second.mean()
    return (
        f"{path.parent.name}: {len(first)} repeats {first.mean():.3f} m, the other {len(second)} "
        f"{second.mean():.3f} m: difference {gap:.3f} m [{low:.3f}, {high:.3f}], p = {found.pvalue:.3f}"
    )


def main() -> None:
    """Prints one line a scene, or the one of the branch."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--scene")
    parser.add_argument("--branch")
    chosen = parser.parse_args()
    if (chosen.scene is None) != (chosen.branch is None):
        parser.error("--scene and --branch go together")
    if chosen.branch is None:
        for scene in params.value("scenes"):
            print(simulated(scene))
        return
    path = Path("reports/branches", chosen.scene, chosen.branch, "evaluation.json")
    returns = np.array([row["return"] for row in read_json(path, f"evaluation@{chosen.branch}")["repeats"]])
    if len(returns) < 4:
        parser.error(f"{path} has {len(returns)} repeats; an A/A takes 4 or more")
    print(real(path, returns))


if __name__ == "__main__":
    main()
