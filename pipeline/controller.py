"""Evolves the controller of one viewpoint: one search per repeat, in the closed loop with the simulator.

Where the VAE's latent does not hold the way to the target, a search has nothing to find: it ends after one
generation, which shows where it would begin.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.contract import params
from pipeline.contract.machine import cores
from pipeline.contract.source import code_digest
from pipeline.contract.split import split_episodes
from pipeline.contract.viewpoints import Viewpoint, viewpoint
from pipeline.control.first import Experience
from pipeline.control.jobs import Networks
from pipeline.control.loops import closed_loops
from pipeline.control.params import ControllerParams, SearchSizes
from pipeline.control.search import Repeat, search_controllers, search_sizes
from pipeline.control.searched import curves, gather_controllers, save_search
from pipeline.learning.device import set_up_torch
from pipeline.sim.scene import Scene, load_scene, with_camera
from pipeline.storage import scratch, zarrs
from pipeline.storage.artefacts import writing
from pipeline.storage.repeats import Place, finished_together
from pipeline.storage.stage import entry

READ = ("mean", "action", "reward")
Models = tuple[Path, Path]


def main(
    *,
    scene: str,
    theta: float,
    phi: float,
    probes: Path,
    latents: Path,
    vae: Path,
    mdnrnn: Path,
    out: Path,
    curve: Path,
    distance: float = 0,
    fov: float = 0,
    first: int = 0,
) -> None:
    """Writes ``out/repeat_{r}.npz`` and the curves of all repeats.

    ``distance``, m, and ``fov``, degrees, are the camera's; 0: the scene's.
    ``probes`` are the VAE's metrics, of which the ``first`` repeats count; without it the budget's.
    """
    compiled, view = with_camera(load_scene(scene), distance, fov), viewpoint(scene, theta, phi)
    sizes = search_sizes(scene, probes, first or params.first_repeats(scene))
    store = zarrs.Store(latents, zarrs.LATENTS, "latents")
    models = [(vae / f"repeat_{r}.pt", mdnrnn / f"repeat_{r}.pt") for r in range(store.repeats)]
    results = evolve_repeats(compiled, view, sizes, store, models)
    table = curves(results)
    with writing(out) as folder:
        gather_controllers(results, folder)
    with writing(curve) as aside:
        table.write_csv(aside)


def evolve_repeats(
    scene: Scene, view: Viewpoint, sizes: SearchSizes, latents: zarrs.Store, models: Sequence[Models]
) -> list[Path]:
    """The scratch folders of the repeats' finished searches; ``models`` are their VAE and MDN-RNN."""
    place, method = set_up_torch(), params.section(ControllerParams, "controller")
    seed, share = params.seed(), params.heldout_share()

    def make(places: Mapping[int, Place]) -> None:
        networks = {r: Networks.load(*models[r], place) for r in places}
        seen = {r: experience(latents, r, share) for r in places}
        repeats = [Repeat(r, seen[r], networks[r].rnn, place.running) for r, place in places.items()]
        loops = closed_loops(scene, view, list(networks.values()), place.device, cores())
        searches = search_controllers(loops, repeats, method, sizes, seed)
        for where, search in zip(places.values(), searches, strict=True):
            save_search(where.results, search, sizes.population * sizes.episodes * scene.frames)

    common: dict[str, Any] = {"code": code_digest("controller"), "machine": place.facts(), "seed": seed}
    common |= {"method": method.model_dump(), "sizes": sizes.model_dump(), "heldout_share": share}
    common |= {"scene": scene.cache_key, "view": view.model_dump()}
    inputs = [scratch.digest_files([latents.place(r), *models[r]]) for r in range(len(models))]
    return finished_together("controller", {r: {**common, "inputs": i} for r, i in enumerate(inputs)}, make)


def experience(latents: zarrs.Store, repeat: int, heldout_share: float) -> Experience:
    """The random episodes of a repeat on which its networks were trained: no other says where to start."""
    arrays = {name: latents.repeat(name, repeat) for name in READ}
    training, _ = split_episodes(len(arrays["reward"]), heldout_share)
    return Experience.of(**{name: array[training] for name, array in arrays.items()})


if __name__ == "__main__":
    entry(main)
