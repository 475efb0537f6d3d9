"""Ranks a scene's viewpoints: a race by repeats that ends with where the camera should stand.

Set BELVEDERE_MIX=allow to rank branches that were made on different devices or versions.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract import params
from pipeline.contract.artefacts import write_json, writing
from pipeline.contract.errors import unknown
from pipeline.contract.stage import entry
from pipeline.stats.answer import Answer, answer, race_part
from pipeline.stats.baselines import compare
from pipeline.stats.branches import Results, read_results
from pipeline.stats.claims import read_claims
from pipeline.stats.dqn import read_dqn
from pipeline.stats.dunnett import tail
from pipeline.stats.pairs import pairs
from pipeline.stats.params import RankingParams
from pipeline.stats.race import Rules
from pipeline.stats.ranks import Ranked, rank
from pipeline.stats.replay import Race, replay
from pipeline.stats.section3 import comparison
from pipeline.stats.words import progress, sentence

MIX_VARIABLE = "BELVEDERE_MIX"  # an environment variable: where a result was made is no parameter


def main(*, scene: str, branches: Path, anchors: Path, claims: Path, out: Path, table: Path) -> None:
    """Reads the branches' evaluations in folder ``branches``; writes ``out`` (JSON), ``table`` (CSV)."""
    method = params.scene_section(RankingParams, "ranking", scene=scene)
    sizes = params.race()
    rules = Rules(sizes.first, sizes.most, method.tolerance, tail(method.confidence, sizes.most))
    asked = [claim for claim in read_claims(claims) if claim.scene == scene]
    results = read_results(scene, branches, anchors, sizes.first, method.sight_share, mix=_mix())
    dqn = read_dqn(branches, list(results.branches))
    raced = [results.scores[key] for key in results.seen]
    race = replay(raced, rules) if raced else None
    rows = rank(results, race, method.confidence)
    found = answer(scene, race, rows, method.confidence, raced)
    keys = list(results.branches)
    content = {
        "scene": scene,
        **_head(results, rules, method),
        "answer": _answer_part(found),
        **_race_part(results, race, rows, method.confidence),
        **comparison(results, dqn, asked, method),
        "baselines": compare(branches, keys, results.common(keys).mean(axis=1)),
        "made_with": _joined(results.made_with),
    }
    write_json(out, content)
    with writing(table) as aside:
        _frame(scene, rows).write_csv(aside)
    print(progress(found))
    if found.kind not in ("open", "cannot see"):
        print(f"{scene}: {sentence(found)}")


def _race_part(results: Results, race: Race | None, rows: list[Ranked], confidence: float) -> dict[str, Any]:
    return {
        "race": race_part(race, results.seen),
        "anchors": {name: float(values.mean()) for name, values in results.anchors.items()},
        "viewpoints": {row.key: {k: v for k, v in asdict(row).items() if k != "key"} for row in rows},
        "pairs": [asdict(pair) for pair in pairs(results.seen, race, confidence)],
        "spread": _spread(race),
    }


def _head(results: Results, rules: Rules, method: RankingParams) -> dict[str, Any]:
    return {
        "confidence": method.confidence,
        "tolerance": method.tolerance,
        "unit_m": results.unit_m,
        "blind_m": results.blind_m,
        "first": rules.first,
        "most": rules.most,
    }


def _answer_part(found: Answer) -> dict[str, Any]:
    return {
        "kind": found.kind,
        "keys": found.keys,
        "within": found.within,
        "sure": found.sure,
        "forecast_trainings": found.forecast,
        "sentence": sentence(found),
        "progress": progress(found),
    }


def _spread(race: Race | None) -> dict[str, float | None]:
    """One repeat's, in score; no key may be "error", which DVC takes for a metric that failed to load."""
    if race is None or not race.last.error.df:
        return {"sd": None, "df": None}
    return {"sd": float(race.last.error.variance) ** 0.5, "df": float(race.last.error.df)}


def _mix() -> bool:
    word = os.environ.get(MIX_VARIABLE, "")
    if word not in ("", "allow"):
        raise unknown(f"environment variable {MIX_VARIABLE}: value", word, ["allow"])
    return word == "allow"


def _joined(made_with: Mapping[str, Mapping[str, Any]]) -> dict[str, str]:
    """What the branches were made with; values that differ stand side by side."""
    names = sorted({name for made in made_with.values() for name in made})
    return {name: " | ".join(sorted({str(made.get(name)) for made in made_with.values()})) for name in names}


def _frame(scene: str, rows: list[Ranked]) -> pl.DataFrame:
    lists = ("misses", "duplicates")
    frame = pl.DataFrame(
        [asdict(row) for row in rows],
        schema_overrides={**dict.fromkeys(lists, pl.List(pl.String)), "out_after": pl.Int64},
        infer_schema_length=None,
    )
    return frame.select(
        pl.lit(scene).alias("scene"),
        "rank",
        pl.col("key").alias("branch"),
        pl.exclude("rank", "key", *lists),
        pl.col("misses").list.join(" and "),
        pl.col("duplicates").list.join(" "),
    )


if __name__ == "__main__":
    entry(main)
