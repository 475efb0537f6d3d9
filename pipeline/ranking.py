"""Ranks a scene's viewpoints: a race by repeats that ends with where the camera should stand.

Set BELVEDERE_MIX=allow to rank branches that were made on different devices or versions.
"""

from __future__ import annotations

from pathlib import Path

import polars as pl

from pipeline.contract import params
from pipeline.contract.declared import check_viewpoints
from pipeline.stats import content
from pipeline.stats.answer import answer
from pipeline.stats.baselines import compare
from pipeline.stats.branches import read_results
from pipeline.stats.claims import read_claims
from pipeline.stats.dqn import read_dqn
from pipeline.stats.factorial_comparison import comparison
from pipeline.stats.messages import progress, sentence
from pipeline.stats.params import RankingParams
from pipeline.stats.race import Rules
from pipeline.stats.ranks import rank
from pipeline.stats.reading import mixture_allowed
from pipeline.stats.replay import replay
from pipeline.stats.tails import tail
from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.stage import entry


def main(*, scene: str, branches: Path, anchors: Path, claims: Path, out: Path, table: Path) -> None:
    """Reads the branches' evaluations in folder ``branches``; writes ``out`` (JSON), ``table`` (CSV)."""
    check_viewpoints()  # DVC takes no dvc.yaml as a dependency
    method = params.scene_section(RankingParams, "ranking", scene=scene)
    sizes = params.race(scene)
    rules = Rules(sizes.first, sizes.most, method.tolerance, tail(method.confidence, sizes.most))
    asked = [claim for claim in read_claims(claims) if claim.scene == scene]
    results = read_results(scene, branches, anchors, sizes.first, params.sight_share(), mix=mixture_allowed())
    dqn = read_dqn(branches, list(results.branches))
    raced = [results.scores[key] for key in results.seen]
    race = replay(raced, rules) if raced else None
    rows = rank(results, race, method.confidence)
    found = answer(scene, race, rows, method.confidence, raced)
    said = {
        "scene": scene,
        **content.head(results, rules, method),
        "answer": content.answer_part(found),
        **content.race_parts(results, race, rows, method.confidence),
        **comparison(results, dqn, asked, method),
        "baselines": compare(branches, results.seen, results.common(results.seen).mean(axis=1))
        if race
        else [],
        "provenance": content.joined(results.provenance),
    }
    write_json(out, said)
    with writing(table) as aside:
        lines = content.table(scene, rows)
        pl.DataFrame(lines, schema_overrides={"out_after": pl.Int64}, infer_schema_length=None).write_csv(
            aside
        )
    print(progress(found))
    if found.kind not in ("open", "cannot see"):
        print(f"{scene}: {sentence(found)}")


if __name__ == "__main__":
    entry(main)
