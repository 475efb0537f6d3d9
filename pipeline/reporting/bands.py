"""Learning curves over repeats: mean and interval at each generation."""

from __future__ import annotations

import polars as pl

from pipeline.stats.blocks import mean_half_width, two_way

POINTS = 160  # a curve drawn 300 pixels wide shows no more


def band(curve: pl.DataFrame, confidence: float) -> pl.DataFrame:
    """The population's mean return by closed-loop frames, over repeats.

    Args:
        curve: columns repeat, generation, frames, mean (m); repeats may differ in length, and
            generations that not every repeat has reached are left out.
        confidence: level of the interval.

    Returns:
        Columns frames, mean, low, high (m); low and high, the two-sided t interval of the mean over
        repeats, are null for a single one. At most ``POINTS`` + 1 rows, the last generation among them.
    """
    repeats = curve["repeat"].n_unique()
    table = (
        curve.sort("generation", "repeat")
        .group_by("generation", maintain_order=True)
        .agg(pl.col("frames").mean(), pl.col("mean").alias("values"), pl.len().alias("count"))
        .filter(pl.col("count") == repeats)
    )
    every = -(-table.height // POINTS)
    table = pl.concat([table.gather_every(every), table.tail(1)]).unique("generation", maintain_order=True)
    fits = [two_way(values.to_numpy()[None, :]) for values in table["values"]]
    halves = pl.Series([mean_half_width(fit, confidence) for fit in fits], dtype=pl.Float64)
    means = pl.Series([float(fit.means[0]) for fit in fits], dtype=pl.Float64)
    return table.select("frames", mean=means, low=means - halves, high=means + halves)


def at_frames(table: pl.DataFrame, frames: float) -> float | None:
    """The mean of a band's last row at or before so many frames; ``None`` before its first."""
    seen = table.filter(pl.col("frames") <= frames)
    return float(seen["mean"][-1]) if seen.height else None


def frames_to(table: pl.DataFrame, level: float) -> float | None:
    """The frames of a band's first row whose mean reaches ``level``; ``None`` if none does."""
    reached = table.filter(pl.col("mean") >= level)
    return float(reached["frames"][0]) if reached.height else None
