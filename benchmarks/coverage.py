"""`./run python -m benchmarks.coverage`: how often the intervals hold, into data/reference/coverage.csv."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl

from pipeline.stats.coverage import POPULATIONS, simulate

OUT = Path("data/reference/coverage.csv")
VIEWS, REPEATS, TABLES, CONFIDENCE, SEED = (2, 6), (3, 5, 10), 20_000, 0.95, 1


def main() -> None:
    """Writes one row per population, number of views and number of repeats."""
    rows = []
    for name, population in POPULATIONS.items():
        for views in VIEWS:
            for repeats in REPEATS:
                rng = np.random.default_rng([SEED, views, repeats])
                found = simulate(population, views, repeats, TABLES, CONFIDENCE, rng)
                numbers = {"means": round(found.means, 3), "differences": round(found.differences, 3)}
                rows.append({"population": name, "views": views, "repeats": repeats, **numbers})
    pl.DataFrame(rows).write_csv(OUT)
    print(pl.DataFrame(rows))


if __name__ == "__main__":
    main()
