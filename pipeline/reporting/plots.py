"""The report's plots of scores and of the race. They draw what tables hold and compute no statistic."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib

from pipeline.reporting import numbers
from pipeline.reporting.rankings import Look
from pipeline.reporting.results import SceneResults, View, short
from pipeline.reporting.svg import COLOURS, RC, inline

import seaborn as sns  # isort: skip  (after svg, which chooses the backend)
from matplotlib.axes import Axes  # isort: skip
from matplotlib.figure import Figure  # isort: skip
from matplotlib.ticker import MaxNLocator  # isort: skip

WIDTH_IN = 5.8
ROW_IN = 0.5
RACE_IN = (5.8, 3.0)
MARKERS = {"leader": "o", "may be as good": "o", "not the best": "s", "cannot see": "x"}
ROLE = {"leader": "best", "may be as good": "tied", "not the best": "worse", "cannot see": "nothing"}
DASHED = (0, (4, 3))

Point = tuple[View, float, float | None, float | None]


@matplotlib.rc_context(RC)
def score_plot(scene: SceneResults) -> str:
    """Scores with their intervals; lines at target-blind (0) and expert (1)."""
    rows = [(v, v.ranked.score_mean, v.ranked.score_low, v.ranked.score_high) for v in scene.views]
    figure, axes = _rows(scene.views)
    _upright(axes, 0.0, "target-blind", "center")
    _upright(axes, 1.0, "expert", "center")
    _points(axes, list(enumerate(rows)))
    axes.set_xlabel("score")
    said = "; ".join(
        f"{v.label} {numbers.score(mean)}{in_brackets(low, high)}" for v, mean, low, high in rows
    )
    return inline(figure, f"score-{scene.name}", f"Scores with intervals: {said}.")


@matplotlib.rc_context(RC)
def behind_plot(scene: SceneResults) -> str:
    """How far each view is behind the leader, with its interval, and the tolerance on the leader's left."""
    rows = [
        (place, (v, 0.0, None, None) if v.ranked.state == "leader" else _behind(v, v.ranked.behind_leader))
        for place, v in enumerate(scene.views)
        if v.ranked.state == "leader" or v.ranked.behind_leader is not None
    ]
    figure, axes = _rows(scene.views)
    _upright(axes, 0.0, "leader", "left")
    _upright(axes, -scene.ranking.tolerance, "tolerance", "right")
    axes.axvspan(-scene.ranking.tolerance, 0.0, color=COLOURS["grid"], alpha=0.5, linewidth=0, zorder=0)
    _points(axes, rows)
    for place in {*range(len(scene.views))} - {place for place, _ in rows}:
        axes.annotate(
            "not in the race", (0, place), xytext=(8, 0), textcoords="offset points", va="center",
            color=COLOURS["muted"],
        )  # fmt: skip
    axes.margins(x=0.12)
    axes.set_xlabel("score behind the leader")
    said = "; ".join(
        f"{v.label} {numbers.score(mean)}{in_brackets(low, high)}" for _, (v, mean, low, high) in rows
    )
    return inline(figure, f"behind-{scene.name}", f"Score behind the leader with intervals: {said}.")


def _behind(view: View, mean: float | None) -> Point:
    return view, mean or 0.0, view.ranked.behind_low, view.ranked.behind_high


@matplotlib.rc_context(RC)
def race_plot(scene: SceneResults) -> str:
    """What the leader may lack of the best after each repeat, the tolerance, and who was eliminated when."""
    looks = [look for look in scene.ranking.race.looks if look.within is not None]
    figure = Figure(figsize=RACE_IN, layout="constrained")
    axes = figure.subplots()
    repeats, within = [look.repeats for look in looks], [look.within or 0.0 for look in looks]
    sns.lineplot(
        x=repeats, y=within, ax=axes, errorbar=None, estimator=None, color=COLOURS["best"], linewidth=2.2,
        marker="o", markersize=8, markeredgecolor=COLOURS["best"],
    )  # fmt: skip
    axes.axhline(scene.ranking.tolerance, color=COLOURS["muted"], linewidth=1.2, linestyle=DASHED, zorder=1)
    axes.annotate(
        "tolerance", (1, scene.ranking.tolerance), xycoords=("axes fraction", "data"), xytext=(-2, 3),
        textcoords="offset points", ha="right", color=COLOURS["muted"],
    )  # fmt: skip
    for look in looks:
        _eliminated(axes, scene, look)
    axes.set_xlim(repeats[0] - 0.5, max(repeats[-1], repeats[0] + 2) + 0.5)
    axes.set_ylim(0, 1.25 * max(*within, scene.ranking.tolerance))
    axes.xaxis.set_major_locator(MaxNLocator(8, integer=True))
    axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.grid(axis="y")
    axes.set_axisbelow(True)
    axes.set_xlabel("repeats")
    axes.set_ylabel("best or within")
    sns.despine(ax=axes)
    said = "; ".join(f"after {look.repeats} repeats {_said(scene, look)}" for look in looks)
    return inline(figure, f"race-{scene.name}", f"The race: {said}.")


def _said(scene: SceneResults, look: Look) -> str:
    leader = "nobody" if look.leader is None else short(look.leader, scene.name)
    return f"{leader} leads, best or within {numbers.at_most(look.within)}"


def _eliminated(axes: Axes, scene: SceneResults, look: Look) -> None:
    keys = [key for key, after in scene.ranking.race.out.items() if after == look.repeats]
    if keys:
        axes.annotate(
            f"{', '.join(scene.labels(keys))} out", (look.repeats, look.within or 0.0), xytext=(6, 8),
            textcoords="offset points", color=COLOURS["worse"],
        )  # fmt: skip


def in_brackets(low: float | None, high: float | None) -> str:
    """An interval behind a number, where there is one."""
    return "" if low is None or high is None else f" ({numbers.interval(low, high)})"


def _upright(axes: Axes, at: float, name: str, side: str) -> None:
    axes.axvline(at, color=COLOURS["muted"], linewidth=1.2, linestyle=DASHED, zorder=1)
    axes.annotate(
        name, (at, 1), xycoords=("data", "axes fraction"), xytext=(0, 4), ha=side,
        textcoords="offset points", color=COLOURS["muted"],
    )  # fmt: skip


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


def _points(axes: Axes, rows: Sequence[tuple[int, Point]]) -> None:
    for row, (view, mean, low, high) in rows:
        state = view.ranked.state
        colour = COLOURS[ROLE[state]]
        if low is not None and high is not None:
            axes.plot([low, high], [row, row], color=colour, linewidth=2.2, solid_capstyle="round")
        axes.plot(
            [mean], [row], MARKERS[state], markersize=8, markeredgewidth=2, color=colour,
            markerfacecolor=COLOURS["paper"] if state == "may be as good" else colour,
        )  # fmt: skip
