"""Tries the controllers of one viewpoint on episodes kept apart, and films one of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract import params
from pipeline.contract.artefacts import write_json, writing
from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.contract.stage import entry
from pipeline.control.clip import write_clip
from pipeline.control.jobs import Job, Networks
from pipeline.control.loops import closed_loops
from pipeline.control.outcomes import evaluation_episodes, made_with, means, outcomes
from pipeline.control.params import EvaluationSizes
from pipeline.control.policy import load_controller
from pipeline.learning.device import compute
from pipeline.sim.camera import viewpoint
from pipeline.sim.scene import load_scene


def main(
    *,
    scene: str,
    theta: float,
    phi: float,
    vae: Path,
    mdnrnn: Path,
    controller: Path,
    out: Path,
    metrics: Path,
    clip: Path,
) -> None:
    """Writes every evaluation episode's outcome, their means, and repeat 0's first episode as a film."""
    compiled, view, place = load_scene(scene), viewpoint(scene, theta, phi), compute()
    count = params.budget_section(EvaluationSizes, "evaluation").episodes
    repeats = range(params.repeats())
    episodes = [evaluation_episodes(compiled, count, params.seed(), r) for r in repeats]
    networks = [Networks.load(vae / f"repeat_{r}.pt", mdnrnn / f"repeat_{r}.pt", place) for r in repeats]
    flat = [load_controller(controller / f"repeat_{r}.npz", compiled.action_size) for r in repeats]
    loops = closed_loops(compiled, view, networks, place.device, cores())
    jobs = [Job.of(r, flat[r][None], episodes[r]) for r in repeats]
    tables = []
    with Progress(len(repeats), f"evaluation {scene} ({theta:g}°, {phi:g}°)") as progress:
        for r, trace in enumerate(loops.run(jobs)):
            tables.append(outcomes(r, episodes[r], trace.tip_m, trace.reward))
            if r == 0:
                write_clip(clip, compiled, view, trace.qpos[0], episodes[0].target_m[0])
            progress.advance(returned=f"{trace.returns.mean():.2f}")
    table = pl.concat(tables)
    with writing(out) as aside:
        table.write_parquet(aside)
    facts = {"scene": scene, "theta_deg": theta, "phi_deg": phi}
    write_json(metrics, {**facts, **means(table, _numbers), "made_with": made_with(place.facts())})


def _numbers(rows: pl.DataFrame) -> dict[str, Any]:
    names = {"return": "return", "final_distance_m": "final_distance_m", "frames_to_5cm": "frames_to_5cm"}
    near = {f"within_{name}_share": f"within_{name}" for name in ("2cm", "5cm")}
    return {name: rows[column].mean() for name, column in {**names, **near}.items()}


if __name__ == "__main__":
    entry(main)
