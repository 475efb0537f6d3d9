"""Every table of the page as rows for machines: unrounded, one file each as CSV and as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.reporting.ablations import SceneAblations
from pipeline.reporting.judge_tables import Factorial
from pipeline.reporting.learning import learned, scene_bands
from pipeline.reporting.page import Reference
from pipeline.reporting.people_tables import Change, PeopleLearning
from pipeline.reporting.people_tests import NextStudy, SignedRanks, Tested, TTest
from pipeline.reporting.results import SceneResults
from pipeline.reporting.search_tables import Search
from pipeline.reporting.searches import SearchResults
from pipeline.reporting.tables import Table
from pipeline.stats.tried import Tried
from pipeline.storage.artefacts import writing

Row = dict[str, Any]


def tables(scenes: Sequence[SceneResults], reference: Reference) -> dict[str, list[Row]]:
    """The page's tables by name; those without a row are left out."""
    recorded = reference.record.scenes if reference.record else []
    found = {
        "ranking": [row for scene in scenes for row in _ranking(scene)],
        "answers": [_answer(scene) for scene in scenes],
        "race": [row for scene in scenes for row in _race(scene)],
        "pairs": [{"scene": s.name, **pair.model_dump()} for s in scenes for pair in s.ranking.pairs],
        "anchors": [{"scene": scene.name, **scene.anchors.model_dump()} for scene in scenes],
        "learning": [row for scene in scenes for row in _learning(scene)],
        "world_models": [row for scene in scenes for row in _world_models(scene)],
        "baselines": [row for scene in scenes for row in _baselines(scene)],
        "effects": [row for scene in scenes for row in _effects(scene)],
        "dqn": [row for scene in scenes for row in _dqn(scene)],
        "claims": [claim.model_dump() for scene in scenes for claim in scene.ranking.claims],
        "people": [row.model_dump() for row in reference.people.found.rows],
        "people_tests": [_tested(row) for row in reference.people.found.tests],
        "people_learning": [_learned(row) for row in reference.people.found.learning],
        "people_course": [row.model_dump() for row in reference.people.found.course],
        "people_implied": [row.model_dump() for row in reference.people.found.published],
        "operator": [row for scene in scenes for row in _operator(scene)],
        "tried": [_tried(row) for scene in reference.tried for row in scene.rows],
        "search_candidates": [row for each in reference.searches for row in _candidates(each.found)],
        "search_mounting": [row for each in reference.searches for row in _mounting(each)],
        "search_finalists": [row for each in reference.searches for row in _finalists(each.found)],
        "ablations": [row for each in reference.ablations for row in _ablations(each)],
        "agreements": [agreement.model_dump() for agreement in reference.people.found.agreements],
        "learning_from_zero": [row for scene in recorded for row in _learning(scene)],
        "claims_from_zero": [claim.model_dump() for scene in recorded for claim in scene.ranking.claims],
        "coverage": [row.model_dump() for row in reference.coverage],
    }
    return {name: rows for name, rows in found.items() if rows}


def write(folder: Path, found: Mapping[str, Sequence[Row]]) -> None:
    """Writes ``folder/NAME.csv`` and ``folder/NAME.json`` for every table."""
    with writing(folder) as aside:
        aside.mkdir()
        for name, rows in found.items():
            pl.DataFrame(rows, infer_schema_length=None).write_csv(aside / f"{name}.csv")
            text = json.dumps(list(rows), indent=1, ensure_ascii=False)
            (aside / f"{name}.json").write_text(text + "\n", encoding="utf-8")


def _flat(name: str, table: type[Table], found: Table | None) -> Row:
    """The entries of a table within a row, under its name; nothing in them where there is none."""
    values = found.model_dump() if found else dict.fromkeys(table.model_fields)
    return {f"{name}_{entry}": value for entry, value in values.items()}


def _tested(row: Tested) -> Row:
    parts: dict[str, type[Table]] = {
        "two_sample": TTest,
        "paired": TTest,
        "signed_ranks": SignedRanks,
        "next": NextStudy,
    }
    flat = row.model_dump(exclude=set(parts))
    for name, table in parts.items():
        flat |= _flat(name, table, getattr(row, name))
    return flat


def _learned(row: PeopleLearning) -> Row:
    named = {"scene": row.scene, "measure": row.measure}
    return {**named, **_flat("trial", Change, row.per_trial), **_flat("block", Change, row.per_block)}


def _operator(scene: SceneResults) -> Iterator[Row]:
    for view in scene.views:
        numbers = view.operator.model_dump()
        looks = numbers.pop("look_m")
        yield {"scene": scene.name, "view": view.key, **numbers} | {
            f"look_{axis}_m": looks.get(axis) for axis in "xyz"
        }


def _tried(row: Tried) -> Row:
    numbers = asdict(row)
    return {**numbers.pop("spot"), **numbers}


def _candidates(search: Search) -> Iterator[Row]:
    for key, row in search.candidates.items():
        yield {"scene": search.scene, "candidate": key, **row.model_dump()}


def _mounting(results: SearchResults) -> Iterator[Row]:
    for key, own in results.mounting.items():
        for off in own.offsets:
            yield {"scene": results.found.scene, "candidate": key, "repeats": own.repeats, **off.model_dump()}


def _ablations(found: SceneAblations) -> Iterator[Row]:
    for key, own in found.views.items():
        for name, part in own.variants.items():
            numbers = part.model_dump(exclude={"scores"})
            yield {"scene": found.scene, "view": key, "variant": name, "repeats": own.repeats, **numbers}


def _finalists(search: Search) -> Iterator[Row]:
    for row in search.viewpoints:
        numbers = row.model_dump()
        yield {"scene": search.scene, **numbers} | {n: " ".join(numbers[n]) for n in ("misses", "duplicates")}


def _ranking(scene: SceneResults) -> Iterator[Row]:
    for view in scene.views:
        row = view.ranked.model_dump()
        ended = view.evaluation.model_dump()
        yield {
            "scene": scene.name,
            "view": view.key,
            **row,
            **{name: " ".join(row[name]) for name in ("misses", "duplicates")},
            **ended,
        }


def _answer(scene: SceneResults) -> Row:
    ranking = scene.ranking
    answer, race = ranking.answer.model_dump(), ranking.race
    return {
        "scene": scene.name,
        **answer,
        "keys": " ".join(answer["keys"]),
        "tolerance": ranking.tolerance,
        "lead_low": race.lead_low,
        "lead_high": race.lead_high,
        "repeats": race.common,
        "trainings": scene.trainings,
        "unit_m": ranking.unit_m,
        "spread_sd": ranking.spread.sd if ranking.spread else None,
        "spread_df": ranking.spread.df if ranking.spread else None,
    }


def _race(scene: SceneResults) -> Iterator[Row]:
    for look in scene.ranking.race.looks:
        row = look.model_dump()
        yield {"scene": scene.name, **row, "active": " ".join(row["active"])}


def _learning(scene: SceneResults) -> Iterator[Row]:
    for row in learned(scene_bands(scene)):
        yield {"scene": scene.name, **asdict(row)}


def _world_models(scene: SceneResults) -> Iterator[Row]:
    for view in scene.views:
        yield {"scene": scene.name, "view": view.key, **view.vae.model_dump(), **view.mdnrnn.model_dump()}


def _baselines(scene: SceneResults) -> Iterator[Row]:
    for row in scene.ranking.baselines:
        agreement = {"tau": row.tau, "p": row.p, "same_sign": row.same_sign}
        for view, value in row.values.items():
            yield {"scene": scene.name, "baseline": row.name, "view": view, "value": value, **agreement}


def _effects(scene: SceneResults) -> Iterator[Row]:
    """Of each judge, and of one over the other."""
    ranking = scene.ranking
    judged: dict[str, Factorial | None] = {
        "world model": ranking.factorial,
        "dqn": ranking.dqn.factorial if ranking.dqn else None,
    }
    for judge, found in judged.items():
        for effect in found.effects if found else ():
            yield {"scene": scene.name, "judge": judge, **effect.model_dump(), "p_holm": None}
    for step in ranking.judges.effects if ranking.judges else ():
        nothing = dict.fromkeys(("equivalence_low", "equivalence_high", "se", "word"))
        row = step.model_dump()
        p = row.pop("p")
        yield {"scene": scene.name, "judge": "world model over dqn", **row, **nothing, "p_holm": p}


def _dqn(scene: SceneResults) -> Iterator[Row]:
    for view, row in scene.ranking.dqn.viewpoints.items() if scene.ranking.dqn else ():
        yield {"scene": scene.name, "view": view, **row.model_dump()}
