"""Learning curves of both judges, one plot per judge and pan angle (as the paper's Figs 7 and 8)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import matplotlib
import polars as pl
from markupsafe import Markup

from pipeline.reporting import numbers
from pipeline.reporting.curves import anchor_levels, curve_axes, level_lines
from pipeline.reporting.results import SceneResults, View
from pipeline.reporting.svg import COLOURS, RC, inline

import seaborn as sns  # isort: skip  (after svg, which chooses the backend)

_STYLES = (("best", "-"), ("worse", (0, (4, 2))))  # of the lower tilt and of the higher


@dataclass(frozen=True)
class JudgePlot:
    """One plot: a judge's curves at one pan angle."""

    judge: str
    theta_deg: float
    svg: Markup


Bands = Mapping[str, pl.DataFrame]  # by branch, what pipeline.reporting.bands.band returns


def judge_plots(scene: SceneResults, judges: Mapping[str, Bands]) -> list[JudgePlot]:
    """Plots of the views that stand at two tilts of the same pan, on common axes.

    Args:
        scene: whose views.
        judges: by name, the bands of each of its views.
    """
    columns = _columns(scene.views)
    tables = [bands[view.key] for bands in judges.values() for views in columns.values() for view in views]
    levels = (scene.anchors.no_op_mean, scene.anchors.expert_mean)
    means = pl.concat([table["mean"] for table in tables])
    bottom, top = min(float(means.min()), *levels), max(float(means.max()), *levels)  # type: ignore[arg-type]
    limits = (bottom - 0.08 * (top - bottom), top + 0.08 * (top - bottom))
    frames = max(float(table["frames"][-1]) for table in tables)
    return [
        JudgePlot(judge, theta, Markup(_plot(scene, judge, theta, views, bands, limits, frames)))
        for judge, bands in judges.items()
        for theta, views in columns.items()
    ]


def _columns(views: Sequence[View]) -> dict[float, list[View]]:
    """The views of each pan angle that has several, by tilt."""
    thetas = sorted({view.ranked.theta_deg for view in views})
    columns = {theta: [view for view in views if view.ranked.theta_deg == theta] for theta in thetas}
    ordered = {theta: sorted(found, key=lambda v: v.ranked.phi_deg) for theta, found in columns.items()}
    return {theta: found[:2] for theta, found in ordered.items() if len(found) > 1}


@matplotlib.rc_context(RC)
def _plot(
    scene: SceneResults,
    judge: str,
    theta_deg: float,
    views: Sequence[View],
    bands: Bands,
    limits: tuple[float, float],
    frames: float,
) -> str:
    figure, axes = curve_axes(limits, frames)
    axes.set_xlabel("frames seen")
    level_lines(axes, anchor_levels(scene.anchors))
    said = []
    for view, (role, dashes) in zip(views, _STYLES, strict=False):
        table = bands[view.key]
        x, colour = table["frames"].to_numpy(), COLOURS[role]
        if table["low"].null_count() == 0:
            low, high = table["low"].to_numpy(), table["high"].to_numpy()
            axes.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0)
        sns.lineplot(
            x=x, y=table["mean"].to_numpy(), ax=axes, errorbar=None, estimator=None, color=colour,
            linewidth=2.2, linestyle=dashes,
        )  # fmt: skip
        tilt = numbers.degrees(view.ranked.phi_deg)
        said.append(f"φ = {tilt} ends at {numbers.metres(table['mean'][-1])} m")
    name = f"judge-{scene.name}-{judge.replace(' ', '-')}-{theta_deg:g}"
    return inline(figure, name, f"{judge}, θ = {numbers.degrees(theta_deg)}: {'; '.join(said)}.")
