"""Measures what returns mean in a scene: doing nothing, moving blindly, and an expert."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from pipeline.contract import params, seeds
from pipeline.contract.artefacts import write_json, writing
from pipeline.contract.machine import cores
from pipeline.contract.repeats import code_digest, finished
from pipeline.contract.seeds import Stream
from pipeline.contract.stage import entry
from pipeline.control.anchors import Policy, blind, expert, nothing, play
from pipeline.control.blind import BlindSearch
from pipeline.control.outcomes import evaluation_episodes, made_with, means, outcomes
from pipeline.control.params import BlindParams, EvaluationSizes, SearchSizes
from pipeline.sim.scene import Scene, load_scene
from pipeline.sim.worlds import Worlds

CODE = ("contract", "control", "sim", "anchors.py")
COMPUTE = {"device": "cpu", "dtype": "float64"}  # MuJoCo's own; it is the same at any number of threads


def main(*, scene: str, out: Path, metrics: Path) -> None:
    """Writes each anchor's episodes, and its mean returns on every repeat's evaluation episodes."""
    compiled = load_scene(scene)
    policies = {"no_op": nothing, "blind": blind(best_blind(compiled)), "expert": expert(compiled)}
    table = pl.concat([judge(compiled, repeat, policies) for repeat in range(params.first_repeats())])
    with writing(out) as aside:
        table.write_parquet(aside)
    write_json(metrics, {"scene": scene, **means(table, _levels), "made_with": made_with(COMPUTE)})


def best_blind(scene: Scene) -> np.ndarray:
    """The best open-loop sequence (t, action_size), from the scratch store or found now."""
    method, sizes = params.section(BlindParams, "anchors"), params.budget_section(SearchSizes, "anchors")

    def make(results: Path, running: Path) -> None:
        rng = seeds.generator(params.seed(), 0, Stream.BLIND)
        np.save(results / "blind.npy", BlindSearch(scene, method, sizes, cores()).best(rng, running))

    decides: dict[str, Any] = {"scene": scene.params.model_dump(), "seed": params.seed()}
    decides |= {"method": method.model_dump(), "sizes": sizes.model_dump()}
    decides |= {"code": code_digest(*CODE), "made_with": made_with(COMPUTE)}
    return np.asarray(np.load(finished("anchors", 0, make, **decides) / "blind.npy"))


def judge(scene: Scene, repeat: int, policies: dict[str, Policy]) -> pl.DataFrame:
    """One repeat's evaluation episodes, under each policy."""
    count = params.budget_section(EvaluationSizes, "evaluation").episodes
    episodes = evaluation_episodes(scene, count, params.seed(), repeat)
    worlds = Worlds(scene, count, cores())
    parts = []
    for name, policy in policies.items():
        rows = outcomes(repeat, episodes, *play(worlds, episodes, policy))
        parts.append(rows.select(pl.lit(name).alias("anchor"), pl.all()))
    return pl.concat(parts)


def _levels(rows: pl.DataFrame) -> dict[str, Any]:
    by = {name: rows.filter(pl.col("anchor") == name) for name in ("no_op", "blind", "expert")}
    near = by["expert"]["within_2cm"].mean()
    return {**{name: part["return"].mean() for name, part in by.items()}, "expert_within_2cm_share": near}


if __name__ == "__main__":
    entry(main)
