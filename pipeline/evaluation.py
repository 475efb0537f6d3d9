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
from pipeline.control.loop import Loop, Trace
from pipeline.control.outcomes import evaluation_episodes, made_with, means, outcomes
from pipeline.control.params import EvaluationSizes
from pipeline.control.policy import Controllers, load_controller
from pipeline.learning.device import Compute, compute
from pipeline.sim.camera import Viewpoint, viewpoint
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene, load_scene
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import load_mdnrnn
from pipeline.worldmodel.vae import load_vae


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
    tables, repeats = [], params.repeats()
    with Progress(repeats, f"evaluation {scene} ({theta:g}°, {phi:g}°)") as progress:
        for r in range(repeats):
            episodes = evaluation_episodes(compiled, count, params.seed(), r)
            models = vae / f"repeat_{r}.pt", mdnrnn / f"repeat_{r}.pt", controller / f"repeat_{r}.npz"
            trace = run(compiled, view, place, episodes, *models)
            tables.append(outcomes(r, episodes, trace.tip_m, trace.reward))
            if r == 0:
                write_clip(clip, compiled, view, trace.qpos[0], episodes.target_m[0])
            progress.advance(returned=f"{trace.returns.mean():.2f}")
    table = pl.concat(tables)
    with writing(out) as aside:
        table.write_parquet(aside)
    facts = {"scene": scene, "theta_deg": theta, "phi_deg": phi}
    write_json(metrics, {**facts, **means(table, _numbers), "made_with": made_with(place.facts())})


def run(
    scene: Scene, view: Viewpoint, place: Compute, episodes: Episodes, vae: Path, mdnrnn: Path, flat: Path
) -> Trace:
    """One repeat's controller in its evaluation episodes."""
    loop = Loop(scene, view, Encoder(load_vae(vae), place), load_mdnrnn(mdnrnn), cores())
    candidate = load_controller(flat, scene.action_size)
    return loop.run(Controllers.of(candidate[None], scene.action_size, each=len(episodes)), episodes)


def _numbers(rows: pl.DataFrame) -> dict[str, Any]:
    names = {"return": "return", "final_distance_m": "final_distance_m", "frames_to_5cm": "frames_to_5cm"}
    near = {f"within_{name}_share": f"within_{name}" for name in ("2cm", "5cm")}
    return {name: rows[column].mean() for name, column in {**names, **near}.items()}


if __name__ == "__main__":
    entry(main)
