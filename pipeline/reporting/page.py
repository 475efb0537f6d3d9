"""The report: one HTML file that needs no network, no script and no other file."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from pipeline.reporting import numbers
from pipeline.reporting.bands import band
from pipeline.reporting.pictures import Pictures, read_pictures
from pipeline.reporting.plots import curve_plots, difference_plot, score_plot
from pipeline.reporting.provenance import Costs, costs, flat, made_with
from pipeline.reporting.results import Coverage, SceneResults, View, short
from pipeline.reporting.section3 import SYMBOLS, claimed, claims, judges_page
from pipeline.reporting.tables import Alignment
from pipeline.reporting.tried import TriedScene

TEMPLATES = Path(__file__).parent / "template"


@dataclass(frozen=True)
class ScenePage:
    """A scene with everything drawn that the template places."""

    results: SceneResults
    headline: str
    chosen: tuple[View, ...]
    pictures: dict[str, Pictures]
    scores: Markup
    differences: Markup
    curves: dict[str, Markup]


@dataclass(frozen=True)
class Reference:
    """What stands beside the results.

    Attributes:
        people: the rankings held against people.
        coverage: how often simulated 95 % intervals held, by population, views and repeats.
        tried: viewpoints of experiments.
    """

    people: Alignment
    coverage: list[Coverage]
    tried: list[TriedScene]


def render(
    scenes: Sequence[SceneResults],
    missing: Sequence[str],
    reference: Reference,
    pictures: Path,
    revision: str,
    parameters: dict[str, Any],
    random_frames: dict[str, int],
) -> str:
    """The page's HTML; the same bytes for the same arguments, files and recorded seconds.

    Args:
        scenes: ranked scenes, in the page's order.
        missing: names of scenes not ranked yet.
        reference: what stands beside the results.
        pictures: folder with one folder of pictures per branch.
        revision: the code's revision, in words.
        parameters: what to name under "parameters"; ``budget`` among them.
        random_frames: of each scene, how many a world model saw before its controller.
    """
    style = (TEMPLATES / "style.css").read_text(encoding="utf-8")
    recorded: Costs = costs(scenes)
    return (
        _environment()
        .get_template("page.html.jinja")
        .render(
            scenes=[_scene_page(scene, pictures) for scene in scenes],
            judges=[page for s in scenes if (page := judges_page(s, random_frames[s.name])) is not None],
            claims=claims(scenes),
            people=reference.people,
            coverage=reference.coverage,
            tried=reference.tried,
            missing=missing,
            style=Markup(style),
            style_hash=_hash(style),
            views=sum(len(scene.views) for scene in scenes),
            repeats=sorted({view.ranked.repeats for scene in scenes for view in scene.views}),
            revision=revision,
            budget=parameters["budget"],
            parameters=flat(parameters),
            made_with=made_with(scenes),
            costs=recorded,
        )
    )


def _scene_page(scene: SceneResults, pictures: Path) -> ScenePage:
    bands = {view.key: band(view.curve, scene.ranking.confidence) for view in scene.views}
    chosen = tuple(view for view in scene.views if view.key in scene.ranking.verdict.keys)
    return ScenePage(
        results=scene,
        headline=headline(scene, chosen),
        chosen=chosen,
        pictures={view.key: read_pictures(pictures / view.key, view.key) for view in scene.views},
        scores=Markup(score_plot(scene)),
        differences=Markup(difference_plot(scene)),
        curves={key: Markup(svg) for key, svg in curve_plots(scene, bands).items()},
    )


def headline(scene: SceneResults, chosen: Sequence[View]) -> str:
    """A scene's verdict in a few words."""
    kind = scene.ranking.verdict.kind
    if kind == "not above blind":
        return "No view is above blind"
    if kind == "not separated":
        more = scene.ranking.verdict.more_repeats
        first_two = " from ".join(view.label for view in scene.views[:2])
        also = f"; about {more} more repeats to tell {first_two}" if more else ""
        return f"Not separated: {', '.join(view.label for view in chosen)}{also}"
    return "Put the camera at " + " or ".join(_angles(view) for view in chosen)


def _angles(view: View) -> str:
    theta, phi = numbers.degrees(view.ranked.theta_deg), numbers.degrees(view.ranked.phi_deg)
    return f"θ = {theta}, φ = {phi}"


def _hash(style: str) -> str:
    """The style sheet's source in a content-security policy."""
    return "sha256-" + base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()


def _environment() -> Environment:
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {
        "metres": numbers.metres,
        "score": numbers.score,
        "cm": numbers.centimetres,
        "percent": numbers.percent,
        "degrees": numbers.degrees,
        "seconds": numbers.seconds,
        "p_value": numbers.p_value,
        "chance": numbers.chance,
        "fixed": numbers.fixed,
        "angles": _angles,
        "claimed": claimed,
        "short": short,
    }
    environment.globals["symbols"] = SYMBOLS
    environment.globals["interval"] = numbers.interval
    return environment
