"""Trains deep Q-networks from one viewpoint: the judge that has neither VAE nor RNN (paper section III)."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract import params, seeds
from pipeline.contract.machine import cores
from pipeline.contract.seeds import Stream
from pipeline.contract.source import code_digest
from pipeline.contract.viewpoints import Viewpoint, viewpoint
from pipeline.control.outcomes import evaluation_episodes, means, provenance
from pipeline.control.params import EvaluationSizes
from pipeline.learning.device import set_up_torch
from pipeline.learning.side_by_side import at_a_time, in_processes
from pipeline.qlearning.actions import best_restricted_expert
from pipeline.qlearning.params import DqnParams, DqnSizes, dqn_params
from pipeline.qlearning.tables import CURVE, EPISODES, joined
from pipeline.qlearning.task_env import TaskEnv
from pipeline.qlearning.training import fit, memory_bytes, require_memory
from pipeline.qlearning.trial import tried
from pipeline.rendering.visibility import refuse_hidden_targets
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene, load_scene
from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.repeats import finished
from pipeline.storage.stage import entry


def main(*, scene: str, theta: float, phi: float, out: Path, curve: Path, metrics: Path) -> None:
    """Writes every evaluation episode's outcome, the curves and the means; empty where none is trained."""
    compiled, view, place = load_scene(scene), viewpoint(scene, theta, phi), set_up_torch()
    refuse_hidden_targets(compiled, view)
    method, sizes = dqn_params(scene)
    require_memory(method, sizes, at_a_time(sizes.repeats))
    results = in_processes(partial(train_repeat, compiled, view, method, sizes), sizes.repeats)
    episodes = joined((r / "episodes.parquet" for r in results), EPISODES)
    curves = joined((r / "curve.parquet" for r in results), CURVE)
    with writing(out) as aside:
        episodes.write_parquet(aside)
    with writing(curve) as aside:
        curves.write_csv(aside)
    facts: dict[str, Any] = {"scene": scene, "theta_deg": theta, "phi_deg": phi, "trained": len(results)}
    facts |= {"replay_memory_bytes": memory_bytes(sizes), **means(episodes, _numbers)}
    write_json(metrics, {**facts, "provenance": provenance(place.facts())})


def train_repeat(scene: Scene, view: Viewpoint, method: DqnParams, sizes: DqnSizes, repeat: int) -> Path:
    """The scratch folder of a repeat's finished ``episodes.parquet`` and ``curve.parquet``."""
    seed, count = params.seed(), params.budget_section(EvaluationSizes, "evaluation", scene.name).episodes
    place = set_up_torch()

    def make(results: Path, running: Path) -> None:
        draws = seeds.generator(seed, repeat, Stream.DQN_EPISODES)
        expert = best_restricted_expert(scene, draw_episodes(scene, count, draws), cores())
        env = TaskEnv(scene, view, method.worlds, draws, cores())
        of_network = seeds.integer(seed, repeat, Stream.DQN)
        trained = fit(env, method, sizes, place, of_network, f"dqn, repeat {repeat}")
        episodes = evaluation_episodes(scene, count, seed, repeat)
        table = tried(trained.model, expert, scene, view, episodes, repeat, cores())
        table.write_parquet(results / "episodes.parquet")
        rows = trained.curve.with_columns(pl.lit(repeat).alias("repeat"))
        rows.select(pl.col(n).cast(t) for n, t in CURVE.items()).write_parquet(results / "curve.parquet")

    cache_key: dict[str, Any] = {"code": code_digest("dqn"), "seed": seed, "evaluated": count}
    cache_key |= {"method": method.model_dump(), "sizes": sizes.model_dump(exclude={"repeats"})}
    cache_key |= {"machine": place.facts(), "scene": scene.cache_key, "view": view.model_dump()}
    return finished("dqn", repeat, make, **cache_key)


def _numbers(rows: pl.DataFrame) -> dict[str, Any]:
    return {name: rows[name].mean() for name in ("return", "final_distance_m", "within_5cm", "expert_return")}


if __name__ == "__main__":
    entry(main)
