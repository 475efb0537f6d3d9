"""Every table of the page as rows for machines: unrounded, one file each as CSV and as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract.artefacts import writing
from pipeline.reporting.page import Reference
from pipeline.reporting.results import SceneResults
from pipeline.stats.factorial import Factorial
from pipeline.stats.tried import Tried

Row = dict[str, Any]


def tables(scenes: Sequence[SceneResults], reference: Reference) -> dict[str, list[Row]]:
    """The page's tables by name; those without a row are left out."""
    found = {
        "ranking": [row for scene in scenes for row in _ranking(scene)],
        "pairs": [{"scene": s.name, **asdict(pair)} for s in scenes for pair in s.ranking.pairs],
        "anchors": [{"scene": scene.name, **scene.anchors.model_dump()} for scene in scenes],
        "world_models": [row for scene in scenes for row in _world_models(scene)],
        "baselines": [row for scene in scenes for row in _baselines(scene)],
        "effects": [row for scene in scenes for row in _effects(scene)],
        "dqn": [row for scene in scenes for row in _dqn(scene)],
        "claims": [claim.model_dump() for scene in scenes for claim in scene.ranking.claims],
        "people": [trial.model_dump() for trial in reference.people.trials],
        "tried": [_tried(row) for scene in reference.tried for row in scene.rows],
        "agreements": [asdict(agreement) for agreement in reference.people.agreements],
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


def _tried(row: Tried) -> Row:
    numbers = asdict(row)
    return {**numbers.pop("spot"), **numbers}


def _ranking(scene: SceneResults) -> Iterator[Row]:
    for view in scene.views:
        row = view.ranked.model_dump()
        ended = view.evaluation.model_dump()
        yield {
            "scene": scene.name,
            "view": view.key,
            **row,
            "duplicates": " ".join(row["duplicates"]),
            **ended,
        }


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
            yield {"scene": scene.name, "judge": judge, **asdict(effect), "p_holm": None}
    for step in ranking.judges.effects if ranking.judges else ():
        nothing = dict.fromkeys(("equivalence_low", "equivalence_high", "word"))
        row = asdict(step)
        p = row.pop("p")
        yield {"scene": scene.name, "judge": "world model over dqn", **row, **nothing, "p_holm": p}


def _dqn(scene: SceneResults) -> Iterator[Row]:
    for view, row in scene.ranking.dqn.viewpoints.items() if scene.ranking.dqn else ():
        yield {"scene": scene.name, "view": view, **row.model_dump()}
