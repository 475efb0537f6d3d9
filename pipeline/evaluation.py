"""Tries the controllers of one viewpoint on episodes kept apart, and films one of them."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import cores
from pipeline.contract.source import code_digest
from pipeline.contract.viewpoints import Viewpoint, viewpoint
from pipeline.control.jobs import Networks
from pipeline.control.loops import closed_loops
from pipeline.control.outcomes import evaluation_episodes, means, provenance
from pipeline.control.params import EvaluationSizes
from pipeline.control.policy import load_controller
from pipeline.control.trial import CLIP, OUTCOMES, numbers, try_out
from pipeline.learning.device import Compute, set_up_torch
from pipeline.sim.episodes import require_episodes
from pipeline.sim.scene import Scene, load_scene, with_camera
from pipeline.storage import scratch
from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.repeats import Place, finished_together
from pipeline.storage.stage import entry


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
    distance: float = 0,
    fov: float = 0,
) -> None:
    """Writes every evaluation episode's outcome, their means, and repeat 0's first episode as a film.

    ``distance``, m, and ``fov``, degrees, are the camera's; 0: the scene's.
    """
    compiled, view = with_camera(load_scene(scene), distance, fov), viewpoint(scene, theta, phi)
    place = set_up_torch()
    repeats = len(list(controller.glob("repeat_*.npz")))
    if not repeats:
        raise BelvedereError(f"{controller} holds no controller; `dvc repro controller` makes it.")
    folders = ((vae, "pt"), (mdnrnn, "pt"), (controller, "npz"))
    models = [[folder / f"repeat_{r}.{kind}" for folder, kind in folders] for r in range(repeats)]
    results = evaluate(compiled, view, place, models)
    table = pl.concat([pl.read_parquet(result / OUTCOMES) for result in results])
    with writing(out) as aside:
        table.write_parquet(aside)
    with writing(clip) as aside:
        shutil.copyfile(results[0] / CLIP, aside)
    facts = {"scene": scene, "theta_deg": theta, "phi_deg": phi}
    write_json(metrics, {**facts, **means(table, numbers), "provenance": provenance(place.facts())})


def evaluate(scene: Scene, view: Viewpoint, place: Compute, models: Sequence[Sequence[Path]]) -> list[Path]:
    """The scratch folders of the repeats' outcomes and clip; ``models``: VAE, MDN-RNN and controller."""
    count, seed = params.budget_section(EvaluationSizes, "evaluation", scene.name).episodes, params.seed()
    require_episodes(scene, count, "evaluation", len(models))

    def make(places: Mapping[int, Place]) -> None:
        networks = [Networks.load(models[r][0], models[r][1], place) for r in places]
        flat = [load_controller(models[r][2], scene.action_size) for r in places]
        episodes = [evaluation_episodes(scene, count, seed, r) for r in places]
        loops = closed_loops(scene, view, networks, place.device, cores())
        try_out(loops, view, flat, episodes, {r: where.results for r, where in places.items()})

    common: dict[str, Any] = {"code": code_digest("evaluation"), "machine": place.facts(), "seed": seed}
    common |= {"scene": scene.cache_key, "view": view.model_dump(), "episodes": count}
    inputs = [scratch.digest_files(files) for files in models]
    return finished_together("evaluation", {r: {**common, "inputs": i} for r, i in enumerate(inputs)}, make)


if __name__ == "__main__":
    entry(main)
