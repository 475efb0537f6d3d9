"""Measures what returns mean in a scene: doing nothing, going blind to the target, and an expert."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract import params, seeds
from pipeline.contract.anchors import anchor_warnings
from pipeline.contract.machine import cores
from pipeline.contract.seeds import Stream
from pipeline.control.anchors import expert, nothing, play
from pipeline.control.blind import TargetBlind
from pipeline.control.outcomes import evaluation_episodes, means, outcomes, provenance
from pipeline.control.params import EvaluationSizes
from pipeline.sim.episodes import require_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds
from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.stage import entry

COMPUTE = {"device": "cpu", "dtype": "float64"}  # MuJoCo's own; it is the same at any number of threads


def main(*, scene: str, out: Path, metrics: Path) -> None:
    """Writes each anchor's episodes, and its mean returns on the first repeats' evaluation episodes."""
    compiled = load_scene(scene)
    count = params.budget_section(EvaluationSizes, "evaluation", scene).episodes
    require_episodes(compiled, count, "evaluation")
    target_blind = TargetBlind(compiled, seeds.generator(params.seed(), 0, Stream.BLIND))
    worlds = Worlds(compiled, count, cores())
    table = pl.concat(
        [measured(worlds, repeat, target_blind) for repeat in range(params.first_repeats(scene))]
    )
    with writing(out) as aside:
        table.write_parquet(aside)
    found = means(table, _levels)
    write_json(metrics, {"scene": scene, **found, "provenance": provenance(COMPUTE)})
    levels = ("no_op_mean", "blind_mean", "expert_mean", "expert_within_2cm_share_mean")
    for warning in anchor_warnings(scene, *(found[name] for name in levels)):
        print(f"warning: {warning}", file=sys.stderr)


def measured(worlds: Worlds, repeat: int, target_blind: TargetBlind) -> pl.DataFrame:
    """One repeat's evaluation episodes, under each policy."""
    scene = worlds.scene
    episodes = evaluation_episodes(scene, worlds.count, params.seed(), repeat)
    blind = target_blind.policy(episodes.start_m)
    parts = []
    for name, policy in {"no_op": nothing, "blind": blind, "expert": expert(scene)}.items():
        played = play(worlds, episodes, policy)
        rows = outcomes(repeat, scene.task, episodes, played.error_m, played.reward)
        parts.append(rows.select(pl.lit(name).alias("anchor"), pl.all()))
    return pl.concat(parts)


def _levels(rows: pl.DataFrame) -> dict[str, Any]:
    by = {name: rows.filter(pl.col("anchor") == name) for name in ("no_op", "blind", "expert")}
    near = by["expert"]["within_2cm"].mean()
    return {**{name: part["return"].mean() for name, part in by.items()}, "expert_within_2cm_share": near}


if __name__ == "__main__":
    entry(main)
