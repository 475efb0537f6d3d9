"""What Q-learning leaves behind: tables of the same columns whether networks were trained or not."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import polars as pl

_PLACES = {f"{place}_{axis}_m": pl.Float64 for place in ("start", "target") for axis in "xyz"}

# One row per evaluation episode; see pipeline.control.outcomes. `expert_return` is the restricted expert's.
EPISODES: dict[str, Any] = {
    "repeat": pl.Int64,
    "episode": pl.Int64,
    "return": pl.Float64,
    "final_distance_m": pl.Float64,
    "within_2cm": pl.Boolean,
    "frames_to_2cm": pl.Int64,
    "within_5cm": pl.Boolean,
    "frames_to_5cm": pl.Int64,
    **_PLACES,
    "expert_return": pl.Float64,
}

# The layout of the controller's curves; a generation is one episode of every world.
CURVE: dict[str, Any] = {
    "repeat": pl.Int64,
    "generation": pl.Int64,
    "frames": pl.Int64,
    "mean": pl.Float64,
    "best": pl.Float64,
}


def joined(files: Iterable[Path], schema: dict[str, Any]) -> pl.DataFrame:
    """The rows of all repeats' ``files``; none where there are none."""
    return pl.concat([pl.DataFrame(schema=schema), *map(pl.read_parquet, files)])
