"""Plots of own trials: each person's means under each view, and the course of the session."""

from __future__ import annotations

import matplotlib
import polars as pl

from pipeline.reporting import numbers
from pipeline.reporting.people_tables import PeopleResults
from pipeline.reporting.svg import COLOURS, RC, inline

import seaborn as sns  # isort: skip  (after svg, which chooses the backend)
from matplotlib.axes import Axes  # isort: skip
from matplotlib.figure import Figure  # isort: skip
from matplotlib.ticker import MaxNLocator  # isort: skip

_BOX_IN = (5.8, 3.6)
_COURSE_IN = (5.8, 3.0)
_MEASURES = (("time_s", 1.0, "task time (s)"), ("distance_m", 100.0, "distance error (cm)"))
_OFFSETS = (0.0, -0.08, 0.08, -0.16, 0.16)  # of points beside one another, so that equal ones are seen
SYNTHETIC = "synthetic"


@matplotlib.rc_context(RC)
def box_plot(results: PeopleResults, scene: str) -> str:
    """Time and distance of a task, a box and everyone's points a view (as the paper's Figs 19 to 21).

    A line joins the points of the same person.
    """
    own = results.means.filter(pl.col("scene") == scene)
    views = own.select("theta", "phi").unique(maintain_order=True).rows()
    figure = Figure(figsize=_BOX_IN, layout="constrained")
    for axes, (column, factor, label) in zip(figure.subplots(1, 2), _MEASURES, strict=True):
        _boxes(axes, own.with_columns(pl.col(column) * factor), views, column)
        axes.set_ylabel(label)
    title = f"{scene}, {SYNTHETIC}" if _is_synthetic(results) else scene
    figure.suptitle(title, fontsize=12, color=COLOURS["ink"])
    people = own["participant"].n_unique()
    said = f"{title}: task time and distance error of {people} participant(s) under {len(views)} views."
    return inline(figure, f"people-{scene}", said)


def _boxes(axes: Axes, own: pl.DataFrame, views: list[tuple[float, float]], column: str) -> None:
    groups = [own.filter((pl.col("theta") == t) & (pl.col("phi") == p)) for t, p in views]
    places = {name: n for n, name in enumerate(sorted(set(own["participant"].to_list())))}
    spots: dict[str, list[tuple[float, float]]] = {}
    for index, group in enumerate(groups):
        if len(group) > 1:
            sns.boxplot(
                x=[index] * len(group), y=group[column].to_list(), ax=axes, native_scale=True, fill=False,
                showfliers=False, width=0.5, color=COLOURS["ink"], saturation=1, linewidth=1.2,
            )  # fmt: skip
        for name, value in zip(group["participant"].to_list(), group[column].to_list(), strict=True):
            spots.setdefault(name, []).append((index + _OFFSETS[places[name] % len(_OFFSETS)], value))
    for points in spots.values():
        x, y = zip(*points, strict=True)
        axes.plot(x, y, color=COLOURS["grid"], linewidth=0.8, zorder=0)
        axes.plot(x, y, "o", color=COLOURS["best"], markersize=4, alpha=0.75, markeredgewidth=0)
    axes.set_xticks(range(len(views)), [f"{numbers.degrees(t)}, {numbers.degrees(p)}" for t, p in views])
    axes.set_xlim(-0.6, len(views) - 0.4)
    axes.set_ylim(0, 1.08 * max(own[column].to_list()))
    axes.yaxis.set_major_locator(MaxNLocator(5))
    axes.grid(axis="y")
    axes.set_axisbelow(True)
    axes.set_xlabel("view (θ, φ)")
    sns.despine(ax=axes)


@matplotlib.rc_context(RC)
def course_plot(results: PeopleResults, what: str) -> str:
    """The session trial by trial: points of all people, and their geometric mean from the table."""
    figure = Figure(figsize=_COURSE_IN, layout="constrained")
    axes = figure.subplots()
    points, means = results.course, results.found.course
    axes.plot(
        points["trial"].to_list(), points[f"relative_{what}"].to_list(), "o", color=COLOURS["muted"],
        markersize=3, alpha=0.5, markeredgewidth=0,
    )  # fmt: skip
    values = [getattr(row, what) for row in means]
    sns.lineplot(
        x=[row.trial for row in means], y=values, ax=axes, errorbar=None, estimator=None,
        color=COLOURS["best"], linewidth=2.2,
    )  # fmt: skip
    axes.axhline(1.0, color=COLOURS["muted"], linewidth=1.0, linestyle=(0, (4, 3)), zorder=0)
    axes.set_ylim(bottom=0)
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True))
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.grid(axis="y")
    axes.set_axisbelow(True)
    marked = f", {SYNTHETIC}" if _is_synthetic(results) else ""
    axes.set_xlabel(f"trial of the session{marked}")
    axes.set_ylabel({"time": "task time, relative", "distance": "distance error, relative"}[what])
    sns.despine(ax=axes)
    ends = f"{numbers.fixed(values[0], 2)} at trial {means[0].trial}"
    last = f"{numbers.fixed(values[-1], 2)} at trial {means[-1].trial}"
    return inline(figure, f"course-{what}", f"Relative {what} over the session{marked}: {ends}, {last}.")


def _is_synthetic(results: PeopleResults) -> bool:
    return results.found.own is not None and results.found.own.synthetic
