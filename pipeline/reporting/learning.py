"""What a scene's controllers start from, what they learn, and how fast."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import polars as pl

from pipeline.reporting.bands import band, frames_to
from pipeline.reporting.results import SceneResults


@dataclass(frozen=True)
class Learned:
    """Of one view's controllers, means over repeats.

    Attributes:
        view: the branch.
        start_m: mean return of generation 0, drawn about the start.
        end_m: of the last generation.
        learned_m: the end less the start.
        level_m: where the lowest of the views ends in which the judge can see; the same for all.
        frames_to_level: closed-loop frames after which this view's mean is there.
    """

    view: str
    start_m: float
    end_m: float
    learned_m: float
    level_m: float
    frames_to_level: float | None


def scene_bands(scene: SceneResults) -> dict[str, pl.DataFrame]:
    """The band of each view's learning curve, by key."""
    return {view.key: band(view.curve, scene.ranking.confidence) for view in scene.views}


def learned(scene: SceneResults, bands: Mapping[str, pl.DataFrame]) -> list[Learned]:
    """One row per view, in the scene's order.

    Args:
        scene: the scene.
        bands: by key, what :func:`pipeline.reporting.bands.band` returns.
    """
    ends = {key: (float(table["mean"][0]), float(table["mean"][-1])) for key, table in bands.items()}
    seeing = [view.key for view in scene.views if view.ranked.state != "cannot see"]
    level = min(ends[key][1] for key in seeing or ends)
    return [
        Learned(v.key, *ends[v.key], ends[v.key][1] - ends[v.key][0], level, frames_to(bands[v.key], level))
        for v in scene.views
    ]
