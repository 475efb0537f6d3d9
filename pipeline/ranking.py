"""Ranks a scene's viewpoints by their mean return, with intervals and a verdict.

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
from pipeline.stats.baselines import compare
from pipeline.stats.branches import read_results
from pipeline.stats.claims import read_claims
from pipeline.stats.dqn import read_dqn
from pipeline.stats.pairs import gap_worth_caring, needed_between, pairs
from pipeline.stats.params import RankingParams
from pipeline.stats.ranks import Ranked, rank
from pipeline.stats.section3 import comparison
from pipeline.stats.verdict import scene_verdict

MIX_VARIABLE = "BELVEDERE_MIX"  # an environment variable: where a result was made is no parameter


def main(*, scene: str, branches: Path, anchors: Path, claims: Path, out: Path, table: Path) -> None:
    """Reads the branches' evaluations in folder ``branches``; writes ``out`` (JSON), ``table`` (CSV)."""
    method = params.section(RankingParams, "ranking")
    confidence = method.confidence
    asked = [claim for claim in read_claims(claims) if claim.scene == scene]
    results = read_results(scene, branches, anchors, mix=_mix())
    dqn = read_dqn(branches, list(results.branches))
    rows, fit = rank(results, confidence)
    compared = pairs(list(results.branches), results.returns, fit, confidence)
    needed = needed_between(compared, {row.key for row in rows[:2]})
    verdict = scene_verdict(scene, rows, confidence, needed)
    content = {
        "scene": scene,
        "confidence": confidence,
        "verdict": asdict(verdict),
        "anchors": {name: float(values.mean()) for name, values in results.anchors.items()},
        "viewpoints": {row.key: {k: v for k, v in asdict(row).items() if k != "key"} for row in rows},
        "pairs": [asdict(pair) for pair in compared],
        "spread": fit.errors(),  # no key may be "error": DVC takes it for a metric that failed to load
        "gap": asdict(gap_worth_caring(results, fit, method)),
        **comparison(results, dqn, asked, method),
        "baselines": compare(branches, list(results.branches), fit.means),
        "made_with": _joined(results.made_with),
    }
    write_json(out, content)
    with writing(table) as aside:
        _frame(scene, rows).write_csv(aside)
    print(f"{scene}: {verdict.sentence}")


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
    frame = pl.DataFrame([asdict(row) for row in rows], schema_overrides={"duplicates": pl.List(pl.String)})
    return frame.select(
        pl.lit(scene).alias("scene"),
        "rank",
        pl.col("key").alias("branch"),
        pl.exclude("rank", "key", "duplicates"),
        pl.col("duplicates").list.join(" "),
    )


if __name__ == "__main__":
    entry(main)
