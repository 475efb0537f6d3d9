"""Evolves the controller of one viewpoint: one search per repeat, in the closed loop with the simulator."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from pipeline.contract import params, scratch, seeds, zarrs
from pipeline.contract.artefacts import writing
from pipeline.contract.machine import cores
from pipeline.contract.seeds import Stream
from pipeline.contract.stage import entry
from pipeline.control.evolution import evolve, start
from pipeline.control.first import Experience, from_rewards
from pipeline.control.loop import Loop
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.control.policy import hidden_weights, parameters, save_controller
from pipeline.learning.device import Compute, compute
from pipeline.learning.repeats import code_digest, finished
from pipeline.sim.camera import Viewpoint, viewpoint
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene, load_scene
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.mdnrnn import load_mdnrnn
from pipeline.worldmodel.vae import load_vae

CODE = ("contract", "control", "learning", "sim", "worldmodel", "controller.py")


READ = ("mean", "action", "reward")


def main(
    *,
    scene: str,
    theta: float,
    phi: float,
    latents: Path,
    vae: Path,
    mdnrnn: Path,
    out: Path,
    curve: Path,
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
    scene: Scene,
    view: Viewpoint,
    place: Compute,
    repeat: int,
    latents: zarrs.Store,
    vae: Path,
    mdnrnn: Path,
) -> Path:
    """The scratch folder of a repeat's finished ``controller.npz`` and ``curve.parquet``."""
    method, sizes = (
        params.section(ControllerParams, "controller"),
        params.budget_section(SearchSizes, "controller"),
    )
    encoder, rnn, seed = Encoder(load_vae(vae), place), load_mdnrnn(mdnrnn), params.seed()
    arrays = {name: latents.repeat(name, repeat) for name in READ}

    def make(results: Path, running: Path) -> None:
        loop = Loop(scene, view, encoder, rnn, cores())

        def judge(candidates: np.ndarray, draws: np.random.Generator) -> np.ndarray:
            return loop.judge(candidates, draw_episodes(scene, sizes.episodes, draws))

        candidates = seeds.generator(seed, repeat, Stream.EVOLUTION)
        draws = seeds.generator(seed, repeat, Stream.TRAINING_EPISODES)
        first = np.zeros(parameters(scene.action_size))
        if method.first == "rewards":
            first = from_rewards(rnn, Experience.of(**arrays), method.ridge)
        shares = np.where(hidden_weights(scene.action_size), method.hidden_share, 1.0)
        search = start(first, sizes.population, method, candidates, draws, shares)
        search = evolve(search, judge, sizes.generations, running, f"controller, repeat {repeat}")
        save_controller(results / "controller.npz", search.incumbent)
        rows = pl.DataFrame(search.curve, schema=["generation", "mean", "best"], orient="row")
        frames = (pl.col("generation") + 1) * (sizes.population * sizes.episodes * scene.frames)
        columns = (pl.lit(repeat).alias("repeat"), "generation", frames.alias("frames"), "mean", "best")
        rows.select(*columns).write_parquet(results / "curve.parquet")

    decides: dict[str, Any] = {"inputs": scratch.digest_files([vae, mdnrnn]), "code": code_digest(*CODE)}
    decides |= {"latents": scratch.digest_arrays(arrays)}
    decides |= {"method": method.model_dump(), "sizes": sizes.model_dump(), "machine": place.facts()}
    decides |= {"seed": seed, "scene": scene.params.model_dump(), "view": view.model_dump()}
    return finished("controller", repeat, make, **decides)


if __name__ == "__main__":
    entry(main)
