"""Evolves the controller of one viewpoint: one search per repeat, in the closed loop with the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract import params, scratch, zarrs
from pipeline.contract.artefacts import writing
from pipeline.contract.machine import cores
from pipeline.contract.stage import entry
from pipeline.control.first import Experience
from pipeline.control.loop import Loop
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.control.policy import save_controller
from pipeline.control.search import search_controller
from pipeline.learning.device import Compute, compute
from pipeline.learning.repeats import code_digest, finished
from pipeline.sim.camera import Viewpoint, viewpoint
from pipeline.sim.scene import Scene, load_scene
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import load_mdnrnn
from pipeline.worldmodel.vae import load_vae

CODE = ("contract", "control", "learning", "sim", "worldmodel", "controller.py")
READ = ("mean", "action", "reward")


def main(
    *, scene: str, theta: float, phi: float, latents: Path, vae: Path, mdnrnn: Path, out: Path, curve: Path
) -> None:
    """Writes ``out/repeat_{r}.npz`` and the curves of all repeats."""
    compiled, view, place = load_scene(scene), viewpoint(scene, theta, phi), compute()
    store = zarrs.Store(latents, zarrs.LATENTS, "latents")
    models = [(vae / f"repeat_{r}.pt", mdnrnn / f"repeat_{r}.pt") for r in range(params.repeats())]
    results = [evolve_repeat(compiled, view, place, r, store, *pair) for r, pair in enumerate(models)]
    with writing(out) as folder:
        folder.mkdir()
        for repeat, result in enumerate(results):
            (folder / f"repeat_{repeat}.npz").write_bytes((result / "controller.npz").read_bytes())
    with writing(curve) as aside:
        pl.concat([pl.read_parquet(result / "curve.parquet") for result in results]).write_csv(aside)


def evolve_repeat(
    scene: Scene, view: Viewpoint, place: Compute, repeat: int, latents: zarrs.Store, vae: Path, mdnrnn: Path
) -> Path:
    """The scratch folder of a repeat's finished ``controller.npz`` and ``curve.parquet``."""
    method = params.section(ControllerParams, "controller")
    sizes, seed = params.budget_section(SearchSizes, "controller"), params.seed()
    encoder, rnn = Encoder(load_vae(vae), place), load_mdnrnn(mdnrnn)
    arrays = {name: latents.repeat(name, repeat) for name in READ}

    def make(results: Path, running: Path) -> None:
        loop, experience = Loop(scene, view, encoder, rnn, cores()), Experience.of(**arrays)
        search = search_controller(loop, experience, method, sizes, seed, repeat, running)
        save_controller(results / "controller.npz", search.incumbent)
        rows = search.table(sizes.population * sizes.episodes * scene.frames)
        rows.insert_column(0, pl.lit(repeat).alias("repeat")).write_parquet(results / "curve.parquet")

    decides: dict[str, Any] = {"inputs": scratch.digest_files([vae, mdnrnn]), "code": code_digest(*CODE)}
    decides |= {"latents": scratch.digest_arrays(arrays)}
    decides |= {"method": method.model_dump(), "sizes": sizes.model_dump(), "machine": place.facts()}
    decides |= {"seed": seed, "scene": scene.params.model_dump(), "view": view.model_dump()}
    return finished("controller", repeat, make, **decides)


if __name__ == "__main__":
    entry(main)
