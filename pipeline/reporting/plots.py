"""The report's plots. They draw what tables hold and compute no statistic."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib
import numpy as np
import polars as pl

from pipeline.reporting import numbers
from pipeline.reporting.results import SceneResults, View
from pipeline.reporting.svg import COLOURS, RC, inline
from pipeline.reporting.tables import Anchors

import seaborn as sns  # isort: skip  (after svg, which chooses the backend)
from matplotlib.axes import Axes  # isort: skip
from matplotlib.figure import Figure  # isort: skip
from matplotlib.ticker import FuncFormatter, MaxNLocator  # isort: skip

WIDTH_IN = 5.8
ROW_IN = 0.5
CURVE_IN = (4.9, 3.1)
CURVE_MARGINS = {"left": 0.17, "right": 0.83, "bottom": 0.19, "top": 0.97}  # shares of the figure
MARKERS = {"best": "o", "not separated": "o", "worse": "s", "not above blind": "x"}
ROLE = {"best": "best", "not separated": "tied", "worse": "worse", "not above blind": "nothing"}


@matplotlib.rc_context(RC)
def score_plot(scene: SceneResults) -> str:
    """Normalised scores with their intervals; lines at blind (0) and expert (1)."""
    rows = [(v, v.ranked.score_mean, v.ranked.score_low, v.ranked.score_high) for v in scene.views]
    figure, axes = _rows(scene.views)
    for at, name in ((0.0, "blind"), (1.0, "expert")):
        axes.axvline(at, color=COLOURS["muted"], linewidth=1.2, linestyle=(0, (4, 3)), zorder=1)
        axes.annotate(
            name, (at, 1), xycoords=("data", "axes fraction"), xytext=(0, 4), ha="center",
            textcoords="offset points", color=COLOURS["muted"],
        )  # fmt: skip
    _points(axes, rows)
    axes.set_xlabel("normalised score")
    said = "; ".join(f"{v.label} {numbers.score(mean)}{_range(low, high)}" for v, mean, low, high in rows)
    return inline(figure, f"score-{scene.name}", f"Normalised scores with intervals: {said}.")


@matplotlib.rc_context(RC)
def difference_plot(scene: SceneResults) -> str:
    """Differences in return to the best view with their intervals; the best itself is the line."""
    rows = [
        (v, v.ranked.difference_to_best or 0.0, v.ranked.difference_low, v.ranked.difference_high)
        for v in scene.views
    ]
    figure, axes = _rows(scene.views)
    axes.axvline(0, color=COLOURS["muted"], linewidth=1.2, zorder=1)
    _points(axes, rows)
    axes.set_xlabel("return less that of the first-ranked (m)")
    said = "; ".join(f"{v.label} {numbers.metres(mean)}{_range(low, high)}" for v, mean, low, high in rows)
    return inline(
        figure,
        f"difference-{scene.name}",
        f"Differences in return to the first-ranked view with intervals: {said}.",
    )


def _range(low: float | None, high: float | None) -> str:
    return "" if low is None or high is None else f" ({numbers.interval(low, high)})"


def _rows(views: Sequence[View]) -> tuple[Figure, Axes]:
    """Axes with one row per view, best on top."""
    figure = Figure(figsize=(WIDTH_IN, 1.0 + ROW_IN * len(views)), layout="constrained")
    axes = figure.subplots()
    axes.set_ylim(len(views) - 0.5, -0.5)
    axes.set_yticks(
        range(len(views)),
        [
            f"{v.label}  ({numbers.degrees(v.ranked.theta_deg)}, {numbers.degrees(v.ranked.phi_deg)})"
            for v in views
        ],
    )
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="x")
    axes.set_axisbelow(True)
    axes.xaxis.set_major_locator(MaxNLocator(6))
    sns.despine(ax=axes, left=True)
    return figure, axes


def _points(axes: Axes, rows: Sequence[tuple[View, float, float | None, float | None]]) -> None:
    for row, (view, mean, low, high) in enumerate(rows):
        verdict = view.ranked.verdict
        colour = COLOURS[ROLE[verdict]]
        if low is not None and high is not None:
            axes.plot([low, high], [row, row], color=colour, linewidth=2.2, solid_capstyle="round")
        axes.plot(
            [mean], [row], MARKERS[verdict], markersize=8, markeredgewidth=2, color=colour,
            markerfacecolor=COLOURS["paper"] if verdict == "not separated" else colour,
        )  # fmt: skip


@matplotlib.rc_context(RC)
def curve_plots(scene: SceneResults, bands: dict[str, pl.DataFrame]) -> dict[str, str]:
    """One learning curve per view, all on the same axes' limits.

    Each shows its own curve solid with its band and, to compare, the first-ranked dashed.

    Args:
        scene: the scene.
        bands: by key, what :func:`pipeline.reporting.bands.band` returns.
    """
    levels = (scene.anchors.no_op_mean, scene.anchors.blind_mean, scene.anchors.expert_mean)
    means = np.concatenate([table["mean"].to_numpy() for table in bands.values()])
    bottom, top = float(min(means.min(), *levels)), float(max(means.max(), *levels))
    margin = 0.08 * (top - bottom or 1.0)
    frames = float(max(table["frames"][-1] for table in bands.values()))
    first = scene.views[0]
    plots = {}
    for view in scene.views:
        figure, axes = curve_axes((bottom - margin, top + margin), frames)
        anchor_lines(axes, scene.anchors)
        if view is not first:
            table = bands[first.key]
            sns.lineplot(
                x=table["frames"].to_numpy(), y=table["mean"].to_numpy(), ax=axes, errorbar=None,
                estimator=None, color=COLOURS["muted"], linewidth=1.6, linestyle=(0, (3, 2)),
            )  # fmt: skip
        _curve(axes, bands[view.key])
        plots[view.key] = inline(figure, f"curve-{view.key}", _curve_alt(view, bands[view.key]))
    return plots


def curve_axes(limits: tuple[float, float], frames: float) -> tuple[Figure, Axes]:
    """Axes of a learning curve: limits of the return (m), and how many frames there are."""
    figure = Figure(figsize=CURVE_IN)  # fixed margins: the views' axes line up
    axes = figure.subplots(gridspec_kw=CURVE_MARGINS)
    axes.set_ylim(*limits)
    axes.set_xlim(0, frames)
    axes.xaxis.set_major_locator(MaxNLocator(4))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:,.0f}".replace(",", "\u202f")))
    axes.grid(axis="y")
    axes.set_axisbelow(True)
    axes.set_xlabel("closed-loop frames")
    axes.set_ylabel("return (m)")
    sns.despine(ax=axes)
    return figure, axes


def anchor_lines(axes: Axes, anchors: Anchors) -> None:
    """Expert, blind and no-op as horizontal lines, named at their right ends."""
    bottom, top = axes.get_ylim()
    lines = sorted(
        [
            (anchors.expert_mean, "expert", (0, (8, 2))),
            (anchors.blind_mean, "blind", (0, (4, 3))),
            (anchors.no_op_mean, "no-op", (0, (1, 2))),
        ]
    )
    names: list[tuple[float, str]] = []
    for level, name, dashes in lines:
        axes.axhline(level, color=COLOURS["muted"], linewidth=1.1, linestyle=dashes, zorder=1)
        if names and level - names[-1][0] < 0.08 * (top - bottom):
            below, label = names[-1]
            names[-1] = ((below + level) / 2, f"{name}\n{label}")
        else:
            names.append((level, name))
    for level, name in names:
        axes.annotate(
            name, (1, level), xycoords=("axes fraction", "data"), xytext=(4, 0), va="center",
            textcoords="offset points", color=COLOURS["muted"], annotation_clip=False,
        )  # fmt: skip


def _curve(axes: Axes, table: pl.DataFrame) -> None:
    x = table["frames"].to_numpy()
    if table["low"].null_count() == 0:
        low, high = table["low"].to_numpy(), table["high"].to_numpy()
        axes.fill_between(x, low, high, color=COLOURS["best"], alpha=0.22, linewidth=0)
    sns.lineplot(
        x=x, y=table["mean"].to_numpy(), ax=axes, errorbar=None, estimator=None,
        color=COLOURS["best"], linewidth=2.2,
    )  # fmt: skip


def _curve_alt(view: View, table: pl.DataFrame) -> str:
    first, last = table.row(0, named=True), table.row(-1, named=True)
    return (
        f"Learning curve of view {view.label}: mean return from {numbers.metres(first['mean'])} m "
        f"to {numbers.metres(last['mean'])} m{_range(last['low'], last['high'])} after "
        f"{last['frames']:.0f} closed-loop frames."
    )
