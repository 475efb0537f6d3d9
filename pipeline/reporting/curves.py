"""Learning curves: what each view's controllers start from and what they learn, beside the leader's."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib
import polars as pl

from pipeline.reporting import numbers
from pipeline.reporting.plots import in_brackets
from pipeline.reporting.results import SceneResults, View
from pipeline.reporting.svg import COLOURS, RC, inline
from pipeline.reporting.tables import Anchors

import seaborn as sns  # isort: skip  (after svg, which chooses the backend)
from matplotlib.axes import Axes  # isort: skip
from matplotlib.figure import Figure  # isort: skip
from matplotlib.ticker import FuncFormatter, MaxNLocator  # isort: skip

SIZE_IN = (4.9, 3.1)
MARGINS = {"left": 0.17, "right": 0.77, "bottom": 0.19, "top": 0.97}  # shares of the figure
NEAR = 0.09  # share of the axis that a line of text takes

Level = tuple[float, str, tuple[int, tuple[int, ...]]]  # return (m), name, dashes


@matplotlib.rc_context(RC)
def curve_plots(scene: SceneResults, bands: Mapping[str, pl.DataFrame], prefix: str = "") -> dict[str, str]:
    """One learning curve per view at which there was a search, all on the same axes' limits.

    Each shows its own curve solid with its band, its start as a ring with a level line, and, to compare,
    the first-ranked view's curve dashed with its band.

    Args:
        scene: the scene.
        bands: by key, what :func:`pipeline.reporting.bands.band` returns.
        prefix: of the plots' identifiers on the page.
    """
    if not bands:
        return {}
    means = pl.concat([table["mean"] for table in bands.values()]).to_list()
    limits = _limits(min(means), max(*means, scene.anchors.expert_mean))
    frames = float(max(table["frames"][-1] for table in bands.values()))
    first = scene.searched[0]
    plots = {}
    for view in scene.searched:
        figure, axes = curve_axes(limits, frames)
        own = bands[view.key]
        level_lines(axes, [*anchor_levels(scene.anchors), (float(own["mean"][0]), "start", (0, (1, 3)))])
        if view is not first:
            _curve(axes, bands[first.key], "muted", (0, (3, 2)))
        _curve(axes, own, "best", "-")
        axes.plot(
            own["frames"][:1], own["mean"][:1], "o", markersize=9, markeredgewidth=2,
            color=COLOURS["best"], markerfacecolor=COLOURS["paper"], zorder=5,
        )  # fmt: skip
        plots[view.key] = inline(figure, f"{prefix}curve-{view.key}", _alt(view, own))
    return plots


def _limits(bottom: float, top: float) -> tuple[float, float]:
    margin = 0.08 * (top - bottom or 1.0)
    return bottom - margin, top + margin


def curve_axes(limits: tuple[float, float], frames: float) -> tuple[Figure, Axes]:
    """Axes of a learning curve: limits of the return (m), and how many frames there are."""
    figure = Figure(figsize=SIZE_IN)  # fixed margins: the views' axes line up
    axes = figure.subplots(gridspec_kw=MARGINS)
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


def anchor_levels(anchors: Anchors) -> list[Level]:
    """The anchors as levels to draw."""
    return [
        (anchors.expert_mean, "expert", (0, (8, 2))),
        (anchors.blind_mean, "target-blind", (0, (4, 3))),
        (anchors.no_op_mean, "no-op", (0, (1, 2))),
    ]


def level_lines(axes: Axes, levels: list[Level]) -> None:
    """Horizontal lines, named at their right ends; those beyond the frame are left out."""
    bottom, top = axes.get_ylim()
    names: list[tuple[float, str]] = []
    near = NEAR * (top - bottom)
    for level, name, dashes in sorted(row for row in levels if bottom <= row[0] <= top):
        axes.axhline(level, color=COLOURS["muted"], linewidth=1.1, linestyle=dashes, zorder=1)
        lines = names[-1][1].count("\n") + 1 if names else 0
        if names and level - names[-1][0] < near * (lines + 1) / 2:
            below, label = names[-1]
            names[-1] = ((lines * below + level) / (lines + 1), f"{name}\n{label}")
        else:
            names.append((level, name))
    for level, name in names:
        axes.annotate(
            name, (1, level), xycoords=("axes fraction", "data"), xytext=(4, 0), va="center",
            textcoords="offset points", color=COLOURS["muted"], annotation_clip=False,
        )  # fmt: skip


def _curve(axes: Axes, table: pl.DataFrame, role: str, dashes: object) -> None:
    x = table["frames"].to_numpy()
    if table["low"].null_count() == 0:
        low, high = table["low"].to_numpy(), table["high"].to_numpy()
        axes.fill_between(x, low, high, color=COLOURS[role], alpha=0.22, linewidth=0)
    sns.lineplot(
        x=x, y=table["mean"].to_numpy(), ax=axes, errorbar=None, estimator=None,
        color=COLOURS[role], linewidth=2.2 if role == "best" else 1.6, linestyle=dashes,
    )  # fmt: skip


def _alt(view: View, table: pl.DataFrame) -> str:
    first, last = table.row(0, named=True), table.row(-1, named=True)
    return (
        f"Learning curve of view {view.label}: mean return from {numbers.metres(first['mean'])} m at the "
        f"start to {numbers.metres(last['mean'])} m{in_brackets(last['low'], last['high'])} after "
        f"{last['frames']:.0f} closed-loop frames."
    )
