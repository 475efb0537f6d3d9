"""What is analysed of trials: each person's means under each view, and the course of its trials."""

from __future__ import annotations

from pathlib import Path

import polars as pl

from pipeline.study.trials import COUNTS, read_table

VIEW = ("scene", "view", "theta", "phi")
MEASURES = ("time_s", "distance_m")
MEANS: dict[str, pl.DataType] = {
    "participant": pl.String(), "scene": pl.String(), "view": pl.String(), "theta": pl.Float64(),
    "phi": pl.Float64(), "trials": pl.Int64(), "time_s": pl.Float64(), "distance_m": pl.Float64(),
}  # fmt: skip
COURSE: dict[str, pl.DataType] = {
    "participant": pl.String(), "session": pl.Int64(), "scene": pl.String(), "view": pl.String(),
    "trial": pl.Int64(), "turn": pl.Int64(), "place": pl.Int64(), "time_s": pl.Float64(),
    "distance_m": pl.Float64(), "relative_time": pl.Float64(), "relative_distance": pl.Float64(),
}  # fmt: skip


def person_means(trials: pl.DataFrame) -> pl.DataFrame:
    """Of each person and view, over the trials that count: how many, mean time and mean distance.

    The means over a person's targets are what the paper tests (section IV-C).
    """
    grouped = trials.filter(COUNTS).group_by("participant", *VIEW)
    found = grouped.agg(pl.len().cast(pl.Int64()).alias("trials"), pl.col(*MEASURES).mean())
    return found.select(*MEANS).sort("scene", "theta", "phi", "participant")


def course(trials: pl.DataFrame) -> pl.DataFrame:
    """Each trial that counts, in its place in the session.

    ``turn``: of its block among the person's blocks of the scene, from 1. ``place``: in the block, from 1.
    ``relative_…``: as a multiple of the person's geometric mean under the same view.
    """
    of_block = ("participant", "session", "block")
    numbered = trials.with_columns(
        (pl.col("trial") - pl.col("trial").min().over(*of_block) + 1).alias("place"),
        pl.struct("session", "block")
        .rank("dense")
        .over("participant", "scene")
        .cast(pl.Int64())
        .alias("turn"),
    )
    own = ("participant", *VIEW)
    relative = [
        (pl.col(m) / pl.col(m).log().mean().over(*own).exp()).alias(f"relative_{m.rpartition('_')[0]}")
        for m in MEASURES
    ]
    positive = pl.all_horizontal(pl.col(m) > 0 for m in MEASURES)
    counted = numbered.filter(COUNTS & positive).with_columns(*relative)
    return counted.select(*COURSE).sort("participant", "session", "trial")


def read_points(path: Path, schema: dict[str, pl.DataType]) -> pl.DataFrame:
    """A table that stage `people` wrote.

    Raises:
        BelvedereError: it is missing, or no such table.
    """
    return read_table(path, schema, "people")
