"""`./run python -m benchmarks.coverage`: how often a race is right, into data/reference/coverage.csv.

One race in 20 may say something wrong. A training's residual has σ = 0.05 in score (a failing one falls 6 σ);
the race goes from 3 to 20 repeats and ends at a tolerance of 0.05.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl

from pipeline.stats.coverage import POPULATIONS, Population, draw, run
from pipeline.stats.race import Rules
from pipeline.stats.tails import tail

OUT = Path("data/reference/coverage.csv")
VIEWS, SITUATIONS = (2, 3, 6), {"tie": 0.0, "0.05 apart": 0.05, "0.1 apart": 0.1}
SPREAD, RULES = 0.05, Rules(first=3, most=20, tolerance=0.05, probability=tail(0.95, 20))
RUNS, AT_ONCE, SEED = 20_000, 2_000, 1


def row(population: Population, views: int, gap: float, runs: int, seed: int) -> dict[str, float]:
    """Shares and means over so many simulated races."""
    rng = np.random.default_rng([seed, views])
    means = np.concatenate([[gap], np.zeros(views - 1)])
    parts = [AT_ONCE] * (runs // AT_ONCE) + [runs % AT_ONCE] * bool(runs % AT_ONCE)
    ends = [run(draw(population, views, gap, SPREAD, n, RULES.most, rng), means, RULES) for n in parts]
    wrong, covered, trainings = (
        np.concatenate([getattr(found, name) for found in ends]) for name in ("wrong", "covered", "trainings")
    )
    shares = {"wrong": round(float(wrong.mean()), 4), "covered": round(float(covered.mean()), 4)}
    return {"runs": runs, **shares, "trainings": round(float(trainings.mean()), 1)}


def main() -> None:
    """Writes one row per population, number of views and true situation."""
    rows = [
        {"population": name, "views": views, "situation": words, **row(population, views, gap, RUNS, SEED)}
        for name, population in POPULATIONS.items()
        for views in VIEWS
        for words, gap in SITUATIONS.items()
    ]
    pl.DataFrame(rows).write_csv(OUT)
    print(pl.DataFrame(rows))


if __name__ == "__main__":
    main()
