"""The report's section on whether the judge matters, and the paper's findings beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import polars as pl

from pipeline.reporting import numbers
from pipeline.reporting.bands import at_frames, band
from pipeline.reporting.judge_plots import JudgePlot, judge_plots
from pipeline.reporting.judge_tables import Held
from pipeline.reporting.results import SceneResults

SYMBOLS = {"theta": "θ", "phi": "φ"}
WORLD_MODEL, DQN = "world model", "DQN"


@dataclass(frozen=True)
class EqualFrames:
    """Mean return (m) of both judges' training episodes once each has seen so many frames."""

    frames: float
    world_model: dict[str, float | None]
    dqn: dict[str, float | None]


@dataclass(frozen=True)
class JudgesPage:
    """A scene in which the paper compares judges.

    Attributes:
        results: the scene.
        plots: the curves, judge by judge and pan by pan; none where no networks were trained.
        equal: both judges after equally many frames, by branch.
    """

    results: SceneResults
    plots: list[JudgePlot]
    equal: EqualFrames | None


def judges_page(scene: SceneResults, random_frames: int) -> JudgesPage | None:
    """The section of a scene; ``None`` for scenes of which the paper asks no such question.

    Args:
        scene: the scene.
        random_frames: that each world model saw before its controller's first.
    """
    if not any(claim.judge != WORLD_MODEL for claim in scene.ranking.claims):
        return None
    views = [view for view in scene.views if view.dqn_curve is not None]
    if not views:
        return JudgesPage(scene, [], None)
    level = scene.ranking.confidence
    ours = {view.key: _later(band(view.curve, level), random_frames) for view in views}
    theirs = {view.key: band(view.dqn_curve, level) for view in views if view.dqn_curve is not None}
    plots = judge_plots(scene, {WORLD_MODEL: ours, DQN: theirs})
    frames = min(float(table["frames"][-1]) for table in (*ours.values(), *theirs.values()))
    reached = [{key: at_frames(table, frames) for key, table in tables.items()} for tables in (ours, theirs)]
    return JudgesPage(scene, plots, EqualFrames(frames, *reached))


def _later(table: pl.DataFrame, frames: int) -> pl.DataFrame:
    """A band whose frames count those seen before it, too."""
    return table.with_columns(pl.col("frames") + frames)


def claims(scenes: Sequence[SceneResults]) -> list[Held]:
    """All claims, section by section."""
    return sorted((c for scene in scenes for c in scene.ranking.claims), key=lambda claim: claim.section)


def claimed(claim: Held) -> str:
    """A claim in words."""
    symbol = SYMBOLS[claim.factor]
    if claim.finding == "none":
        return f"{symbol} makes no difference"
    if claim.first_deg is None or claim.second_deg is None:
        raise ValueError(f"a claim of {claim.scene} names no levels")
    first, second = numbers.degrees(claim.first_deg), numbers.degrees(claim.second_deg)
    return f"{symbol} = {first} gives more than {symbol} = {second}"
