"""What a scene's controllers start from, what they learn, and how fast."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import polars as pl

from pipeline.reporting.bands import band, frames_to
from pipeline.reporting.results import SceneResults

QUARTER = 4


@dataclass(frozen=True)
class Learned:
    """Of one view's controllers, means over repeats.

    Attributes:
        view: the branch.
        start_m: mean return of generation 0, drawn about the start.
        end_m: of the last quarter of the generations, since each has episodes of its own.
        learned_m: the end less the start.
        level_m: where the lowest of the views ends; the same for all.
        frames_to_level: closed-loop frames after which this view's mean is there.
    """

    view: str
    start_m: float
    end_m: float
    learned_m: float
    level_m: float
    frames_to_level: float | None


def scene_bands(scene: SceneResults) -> dict[str, pl.DataFrame]:
    """By key, the band of each view's learning curve, where there was a search; in the order of ranks."""
    return {view.key: band(view.curve, scene.ranking.confidence) for view in scene.searched}


def learned(bands: Mapping[str, pl.DataFrame]) -> list[Learned]:
    """One row per view.

    Args:
        bands: by key, what :func:`pipeline.reporting.bands.band` returns.
    """
    starts = {key: float(table["mean"][0]) for key, table in bands.items()}
    ends = {key: _end(table) for key, table in bands.items()}
    level = min(ends.values(), default=0.0)
    return [
        Learned(key, starts[key], ends[key], ends[key] - starts[key], level, frames_to(table, level))
        for key, table in bands.items()
    ]


def _end(table: pl.DataFrame) -> float:
    last = table["mean"].tail(-(-table.height // QUARTER)).to_list()
    return sum(last) / len(last)
