"""The page's section on viewpoints tried in experiments: a table and a θ-φ plot per scene."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import polars as pl
from markupsafe import Markup

from pipeline.contract import params
from pipeline.reporting import numbers
from pipeline.reporting.csv_frames import read_frame
from pipeline.reporting.results import SceneResults
from pipeline.reporting.svg import COLOURS, RC, inline
from pipeline.stats.tried import Spot, Tried, tried

import seaborn as sns  # isort: skip  (after svg, which chooses the backend)
from matplotlib.figure import Figure  # isort: skip

# One row per repeat; what pipeline.reporting.gather writes.
COLUMNS: dict[str, Any] = {
    "experiment": pl.String,
    "scene": pl.String,
    "theta_deg": pl.Float64,
    "phi_deg": pl.Float64,
    "budget": pl.String,
    "parameters": pl.String,
    "repeat": pl.Int64,
    "return": pl.Float64,
    "score": pl.Float64,
}
_AREA = 500.0  # of a mark at score 1, square points
_LEAST_AREA = 12.0


@dataclass(frozen=True)
class TriedScene:
    """A scene in which viewpoints were tried.

    Attributes:
        name: the scene's.
        budget: at which.
        rows: best first.
        plot: where they stand, and what they scored.
    """

    name: str
    budget: str
    rows: list[Tried]
    plot: Markup


def read_tried(path: Path) -> pl.DataFrame:
    """The table that the command `gather` wrote; without a row where nothing was gathered.

    Raises:
        BelvedereError: the file is missing or foreign.
    """
    what, remedy = "table of viewpoints tried", f"`python -m pipeline.reporting.gather --out {path}` makes it"
    return read_frame(path, COLUMNS, what, remedy)


def parameters_digest(scene: str) -> str:
    """A hash of what decides a viewpoint's result in a scene, but for the viewpoint and its repeats."""
    sized = ("rollouts", "vae", "mdnrnn", "controller", "evaluation")
    sizes = params.value("budgets")[params.budget()]
    settings = [
        params.seed(),
        params.heldout_share(),
        params.sight_share(),
        params.first_repeats(scene),
        {name: sizes.get(name) for name in sized},
        params.value("rollouts"),
        params.value("vae"),
        params.value("mdnrnn"),
        params.value("controller"),
        params.value("scenes")[scene],
    ]
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()[:16]


def of_these_parameters(table: pl.DataFrame, path: Path) -> pl.DataFrame:
    """The rows that were gathered with the parameters as they are; says which are not.

    Args:
        table: the content of ``path``.
        path: the file, to be named.
    """
    now = {scene: parameters_digest(scene) for scene in params.value("scenes")}
    fits = [row["parameters"] == now.get(row["scene"]) for row in table.to_dicts()]
    kept = table.filter(pl.Series(fits, dtype=pl.Boolean))
    others = sorted(set(table["experiment"]) - set(kept["experiment"]))
    if others:
        print(
            f"left out of the page: {', '.join(others)} in {path}, gathered with other parameters than "
            f"{params.PARAMS_FILE} has now; `python -m pipeline.reporting.gather --out {path}` gathers again",
            file=sys.stderr,
        )
    return kept


def tried_scenes(table: pl.DataFrame, scenes: Sequence[SceneResults]) -> list[TriedScene]:
    """One entry per scene that is on the page and in the table."""
    found = []
    for scene in scenes:
        own = table.filter(pl.col("scene") == scene.name).sort("theta_deg", "phi_deg", "experiment", "repeat")
        if own.is_empty():
            continue
        runs: dict[Spot, list[tuple[float, float]]] = {}
        for row in own.to_dicts():
            spot = Spot(row["experiment"], row["scene"], row["theta_deg"], row["phi_deg"])
            runs.setdefault(spot, []).append((row["return"], row["score"]))
        rows = sorted(tried(runs, scene.ranking.confidence), key=lambda row: -row.score_mean)
        found.append(TriedScene(scene.name, own["budget"][0], rows, Markup(_plot(scene, rows))))
    return found


@matplotlib.rc_context(RC)
def _plot(scene: SceneResults, rows: Sequence[Tried]) -> str:
    """Pan across, tilt up; a mark's area is the score, which is written beside it."""
    figure = Figure(figsize=(5.8, 3.8), layout="constrained")
    axes = figure.subplots()
    here = {(row.spot.theta_deg, row.spot.phi_deg) for row in rows}
    ranked = [(v.ranked.theta_deg, v.ranked.phi_deg, v.ranked.score_mean) for v in scene.views]
    others = [place for place in ranked if place[:2] not in here]
    ours = [(row.spot.theta_deg, row.spot.phi_deg, row.score_mean) for row in rows]
    for places, marker, colour, name in (
        (others, "s", COLOURS["muted"], "ranked above"),
        (ours, "o", COLOURS["best"], "tried"),
    ):
        if not places:
            continue
        theta, phi, score = zip(*places, strict=True)
        areas = [max(_LEAST_AREA, _AREA * value) for value in score]
        axes.scatter(theta, phi, areas, marker=marker, facecolor="none", edgecolor=colour, label=name)
        for place in places:
            axes.annotate(
                numbers.score(place[2]), place[:2], xytext=(0, 14), textcoords="offset points", ha="center"
            )
    axes.set_xlabel("pan θ (°)")
    axes.set_ylabel("tilt φ (°)")
    axes.margins(0.18)
    axes.legend(frameon=False, markerscale=0.5, loc="best")
    sns.despine(ax=axes)
    said = [f"({numbers.degrees(t)}, {numbers.degrees(p)}) {numbers.score(score)}" for t, p, score in ours]
    alt = f"Scores of the viewpoints tried in {scene.name}: {'; '.join(said)}."
    return inline(figure, f"tried-{scene.name}", alt)
