"""Tries the controllers of one viewpoint on episodes kept apart, and films one of them."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract import params, scratch
from pipeline.contract.artefacts import write_json, writing
from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.contract.repeats import Place, code_digest, finished_together
from pipeline.contract.stage import entry
from pipeline.control.clip import write_clip
from pipeline.control.jobs import Job, Networks
from pipeline.control.loops import closed_loops
from pipeline.control.outcomes import evaluation_episodes, made_with, means, outcomes
from pipeline.control.params import EvaluationSizes
from pipeline.control.policy import load_controller
from pipeline.learning.device import Compute, compute
from pipeline.sim.camera import Viewpoint, viewpoint
from pipeline.sim.scene import Scene, load_scene

CODE = ("contract", "control", "learning", "sim", "worldmodel", "evaluation.py")


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
    repeats = len(list(controller.glob("repeat_*.npz")))
    if not repeats:
        raise BelvedereError(f"{controller} holds no controller; `dvc repro controller` makes it.")
    models = [
        [vae / f"repeat_{r}.pt", mdnrnn / f"repeat_{r}.pt", controller / f"repeat_{r}.npz"]
        for r in range(repeats)
    ]
    results = evaluate(compiled, view, place, models)
    table = pl.concat([pl.read_parquet(result / "outcomes.parquet") for result in results])
    with writing(out) as aside:
        table.write_parquet(aside)
    with writing(clip) as aside:
        shutil.copyfile(results[0] / "clip.webp", aside)
    facts = {"scene": scene, "theta_deg": theta, "phi_deg": phi}
    write_json(metrics, {**facts, **means(table, _numbers), "made_with": made_with(place.facts())})


def evaluate(scene: Scene, view: Viewpoint, place: Compute, models: Sequence[Sequence[Path]]) -> list[Path]:
    """The scratch folders of the repeats' finished ``outcomes.parquet`` and ``clip.webp``.

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        place: where networks run.
        models: of each repeat the files of its VAE, MDN-RNN and controller.
    """
    count, seed = params.budget_section(EvaluationSizes, "evaluation", scene.name).episodes, params.seed()

    def make(places: Mapping[int, Place]) -> None:
        networks = [Networks.load(models[r][0], models[r][1], place) for r in places]
        flat = [load_controller(models[r][2], scene.action_size)[None] for r in places]
        episodes = [evaluation_episodes(scene, count, seed, r) for r in places]
        loops = closed_loops(scene, view, networks, place.device, cores())
        traces = loops.run([Job.of(i, flat[i], episodes[i]) for i in range(len(places))])
        what = f"evaluation {scene.name} ({view.theta:g}°, {view.phi:g}°)"
        with Progress(len(places), what) as progress:
            for (r, where), own, trace in zip(places.items(), episodes, traces, strict=True):
                table = outcomes(r, own, trace.tip_m, trace.reward)
                table.write_parquet(where.results / "outcomes.parquet")
                if r == 0:
                    write_clip(where.results / "clip.webp", scene, view, trace.qpos[0], own.target_m[0])
                progress.advance(returned=f"{trace.returns.mean():.2f}")

    common: dict[str, Any] = {"code": code_digest(*CODE), "machine": place.facts(), "seed": seed}
    common |= {"scene": scene.params.model_dump(), "view": view.model_dump(), "episodes": count}
    inputs = [scratch.digest_files(files) for files in models]
    return finished_together("evaluation", {r: {**common, "inputs": i} for r, i in enumerate(inputs)}, make)


def _numbers(rows: pl.DataFrame) -> dict[str, Any]:
    names = {"return": "return", "final_distance_m": "final_distance_m", "frames_to_5cm": "frames_to_5cm"}
    near = {f"within_{name}_share": f"within_{name}" for name in ("2cm", "5cm")}
    return {name: rows[column].mean() for name, column in {**names, **near}.items()}


if __name__ == "__main__":
    entry(main)
