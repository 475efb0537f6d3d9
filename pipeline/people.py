"""Analyses people's trials, the published ones and the study's own, and holds the rankings against them."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

from pipeline.contract import params
from pipeline.stats.agreement import Published, Ranking, agreements, compare
from pipeline.stats.people import compared_pairs, rows, view_pairs
from pipeline.stats.published import implied
from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.stage import entry
from pipeline.storage.tables import read_model
from pipeline.study import analysis
from pipeline.study.means import course, person_means
from pipeline.study.params import PeopleParams
from pipeline.study.subjects import read_subjects
from pipeline.study.trials import read_trials


def main(*, trials: Path, subjects: Path, rankings: Path, out: Path, points: Path) -> None:
    """Writes what the page tells of people.

    Args:
        trials: all ended attempts of the study, Parquet.
        subjects: the published table, CSV.
        rankings: folder of the scenes' rankings.
        out: JSON, which goes into git: of the study's own people aggregates only.
        points: folder of the Parquet tables that the plots draw, people's own values; never in git.
    """
    asked, own, published = (
        params.section(PeopleParams, "people"),
        read_trials(trials),
        read_subjects(subjects),
    )
    means, trial_by_trial, synthetic = person_means(own), course(own), analysis.is_synthetic(own)
    pairs = view_pairs(analysis.measured(means), [(row.scene, *row.views) for row in published])
    tested = compared_pairs(pairs, asked.alpha, asked.power, synthetic)
    summary = analysis.summary(own)
    together = [*published, *(rows(tested, summary["source"]) if summary else [])]
    found = {scene: rankings / f"{scene}.json" for scene in params.value("scenes")}
    ranked = {s: read_model(Ranking, path, f"ranking@{s}") for s, path in found.items() if path.is_file()}
    compared = compare(together, ranked)
    with writing(points) as aside:
        aside.mkdir()
        means.write_parquet(aside / "means.parquet")
        trial_by_trial.write_parquet(aside / "course.parquet")
    content = {
        "own": summary,
        "alpha": asked.alpha,
        "power": asked.power,
        "rows": [row.model_dump() for row in compared],
        "agreements": [asdict(agreement) for agreement in agreements(compared)],
        "tests": [asdict(row) for row in tested],
        "learning": analysis.learning(trial_by_trial, asked.alpha, synthetic),
        "course": analysis.course_of_all(trial_by_trial, synthetic),
        "published": [_implied(row, asked) for row in published],
    }
    write_json(out, content)


def _implied(row: Published, asked: PeopleParams) -> dict[str, Any]:
    named = row.model_dump(include={"source", "scene", "measure", "unit"})
    return {**named, **asdict(implied(row.first, row.second, row.p, row.people, asked.alpha, asked.power))}


if __name__ == "__main__":
    entry(main)
