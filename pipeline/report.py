"""report: one self-contained HTML page over all scenes, answers first."""

from __future__ import annotations

from pathlib import Path

from pipeline.contract import params
from pipeline.contract.errors import unknown
from pipeline.reporting import exports
from pipeline.reporting.ablations import read_ablations
from pipeline.reporting.page import Made, Reference, render
from pipeline.reporting.people_tables import read_people
from pipeline.reporting.provenance import revision
from pipeline.reporting.record import read_record
from pipeline.reporting.results import read_coverage, read_results
from pipeline.reporting.searches import read_searches
from pipeline.reporting.tried import of_these_parameters, read_tried, tried_scenes
from pipeline.storage.artefacts import writing
from pipeline.storage.stage import entry


def main(
    *,
    rankings: Path,
    branches: Path,
    anchors: Path,
    people: Path,
    points: Path,
    coverage: Path,
    tried: Path,
    record: Path,
    searches: Path,
    ablations: Path,
    pictures: Path,
    out: Path,
    tables: Path,
) -> None:
    """Writes the report.

    Args:
        rankings: folder of the scenes' rankings.
        branches: folder of the branches' tables, by scene.
        anchors: folder of the scenes' anchors.
        people: people's trials, and the rankings held against them.
        points: folder of people's own values, which the plots draw.
        coverage: how often simulated races ended with a false statement.
        tried: viewpoints that experiments tried, one row per repeat.
        searches: folder of searches over the sphere.
        ablations: folder of what judges reach without one of their parts, by scene.
        record: folder of a run whose controllers were searched for from zero.
        pictures: folder of the branches' pictures; those that are absent are named on the page.
        out: the HTML file.
        tables: folder of the page's tables as CSV and JSON.
    """
    scenes, missing = read_results(list(params.value("scenes")), rankings, branches, anchors)
    found = tried_scenes(of_these_parameters(read_tried(tried), tried), scenes)
    people_results = read_people(people, points)
    reference = Reference(
        people=people_results,
        coverage=read_coverage(coverage),
        tried=found,
        record=read_record(record),
        searches=read_searches(searches),
        ablations=read_ablations(ablations),
    )
    start = str(params.value("controller", "first"))
    made = Made(revision(), _parameters(), _random_frames(), start, searches)
    page = render(scenes, missing, reference, pictures, made)
    exports.write(tables, exports.tables(scenes, reference))
    with writing(out) as aside:
        aside.write_text(page, encoding="utf-8")


def _parameters() -> dict[str, object]:
    """What decides the scale of the results."""
    budget, budgets = params.value("budget"), params.value("budgets")
    if budget not in budgets:
        raise unknown(f"budget (in {params.PARAMS_FILE})", budget, budgets)
    return {
        "budget": budget,
        "seed": params.seed(),
        "heldout_share": params.heldout_share(),
        budget: budgets[budget],
    }


def _random_frames() -> dict[str, int]:
    """By scene, the frames of a repeat's random episodes."""
    sizes = params.value("budgets")[params.budget()]["rollouts"]
    named = sizes.get("scenes", {})
    scenes = params.value("scenes")
    return {s: (sizes | named.get(s, {}))["episodes"] * scenes[s]["frames"] for s in scenes}


if __name__ == "__main__":
    entry(main)
