"""The report: one HTML file that needs no network, no script and no other file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from pipeline.reporting import numbers
from pipeline.reporting.ablations import SceneAblations
from pipeline.reporting.curves import curve_plots
from pipeline.reporting.factorial_comparison import claims, judges_page
from pipeline.reporting.learning import Learned, learned, scene_bands
from pipeline.reporting.people_page import people_page
from pipeline.reporting.people_tables import PeopleResults
from pipeline.reporting.pictures import Pictures, read_pictures
from pipeline.reporting.plots import behind_plot, race_plot, score_plot
from pipeline.reporting.provenance import costs, flat, provenance
from pipeline.reporting.record import Record
from pipeline.reporting.results import Coverage, SceneResults, View
from pipeline.reporting.searches import SearchResults, search_pages
from pipeline.reporting.templates import TEMPLATES, environment, source_hash
from pipeline.reporting.tried import TriedScene


@dataclass(frozen=True)
class ScenePage:
    """A scene with everything drawn that the template places.

    Attributes:
        results: the scene.
        headline, rest: the answer's first sentence, and what follows it.
        shown: the views whose pictures stand beside the answer.
        pictures: by branch.
        scores: the plot of all views.
        behind: the plot of the race as it stands; ``None`` where none was run.
        race: its course; ``None`` where there was one look at most.
        curves: learning curves by branch.
        learned: the same in numbers.
    """

    results: SceneResults
    headline: str
    rest: str
    shown: tuple[View, ...]
    pictures: dict[str, Pictures]
    scores: Markup
    behind: Markup | None
    race: Markup | None
    curves: dict[str, Markup]
    learned: list[Learned]


@dataclass(frozen=True)
class Reference:
    """What stands beside the results.

    Attributes:
        people: people's trials, published and own, and the rankings held against them.
        coverage: simulated races, and how often they ended with a false statement.
        tried: viewpoints of experiments.
        searches: over the sphere.
        ablations: the judge without one of its parts, by scene.
        record: the run in which controllers were searched for from zero, where one is kept.
    """

    people: PeopleResults
    coverage: list[Coverage]
    tried: list[TriedScene]
    record: Record | None
    searches: list[SearchResults]
    ablations: list[SceneAblations]


@dataclass(frozen=True)
class Made:
    """How the results were made.

    Attributes:
        revision: the code's, in words.
        parameters: what to name under "parameters"; ``budget`` among them.
        random_frames: of each scene, how many a world model saw before its controller.
        start: where a controller's search starts, see ``controller.first`` in params.yaml.
        searches: folder of searches over the sphere, with their pictures.
    """

    revision: str
    parameters: dict[str, Any]
    random_frames: dict[str, int]
    start: str
    searches: Path


def render(
    scenes: Sequence[SceneResults], missing: Sequence[str], reference: Reference, pictures: Path, made: Made
) -> str:
    """The page's HTML; the same bytes for the same arguments, files and recorded seconds.

    Args:
        scenes: ranked scenes, in the page's order.
        missing: names of scenes not ranked yet.
        reference: what stands beside the results.
        pictures: folder with one folder of pictures per branch.
        made: how the results were made.
    """
    style = (TEMPLATES / "style.css").read_text(encoding="utf-8")
    return (
        environment()
        .get_template("page.html.jinja")
        .render(
            **_results(scenes, pictures, made.random_frames),
            people=people_page(reference.people),
            coverage=reference.coverage,
            tried=reference.tried,
            searches=search_pages(reference.searches, reference.tried, made.searches),
            ablations=reference.ablations,
            record=reference.record,
            **_record(reference.record),
            missing=missing,
            start=made.start,
            style=Markup(style),
            style_hash=source_hash(style),
            revision=made.revision,
            budget=made.parameters["budget"],
            seed=made.parameters["seed"],
            parameters=flat(made.parameters),
        )
    )


def _results(scenes: Sequence[SceneResults], pictures: Path, random_frames: dict[str, int]) -> dict[str, Any]:
    """What the template says of the ranked scenes."""
    return {
        "scenes": [_scene_page(scene, pictures) for scene in scenes],
        "judges": [page for s in scenes if (page := judges_page(s, random_frames[s.name])) is not None],
        "claims": claims(scenes),
        "views": sum(len(scene.views) for scene in scenes),
        "trainings": sum(scene.trainings for scene in scenes),
        "provenance": provenance(scenes),
        "costs": costs(scenes),
    }


def _record(record: Record | None) -> dict[str, Any]:
    """What the template says of the record, where there is one."""
    if record is None:
        return {}
    bands = {scene.name: scene_bands(scene) for scene in record.scenes}
    curves = {scene.name: curve_plots(scene, bands[scene.name], "zero-") for scene in record.scenes}
    drawn = {name: {key: Markup(svg) for key, svg in plots.items()} for name, plots in curves.items()}
    found = {name: learned(own) for name, own in bands.items()}
    return {"record_claims": claims(record.scenes), "record_curves": drawn, "record_learned": found}


def _scene_page(scene: SceneResults, pictures: Path) -> ScenePage:
    bands, looks = scene_bands(scene), len(scene.ranking.race.looks)
    headline, _, rest = numbers.unbroken(scene.ranking.answer.sentence).partition(". ")
    return ScenePage(
        results=scene,
        headline=f"{headline}." if rest else headline,
        rest=rest,
        shown=_shown(scene),
        pictures={view.key: read_pictures(pictures / view.key, view.key) for view in scene.views},
        scores=Markup(score_plot(scene)),
        behind=Markup(behind_plot(scene)) if looks else None,
        race=Markup(race_plot(scene)) if looks > 1 else None,
        curves={key: Markup(svg) for key, svg in curve_plots(scene, bands).items()},
        learned=learned(bands),
    )


def _shown(scene: SceneResults) -> tuple[View, ...]:
    """Where the camera may be put: the leader, or both views between which the answer leaves the choice."""
    answer = scene.ranking.answer
    chosen = answer.keys if answer.kind == "either" else answer.keys[:1]
    return tuple(view for key in chosen for view in scene.views if view.key == key)
