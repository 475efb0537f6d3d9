"""Trains the VAE of one viewpoint: one network per repeat, with probes of what it sees."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract import params, seeds
from pipeline.contract.seeds import Stream
from pipeline.contract.source import code_digest
from pipeline.contract.split import split_episodes
from pipeline.learning import checkpoints
from pipeline.learning.device import Compute, set_up_torch
from pipeline.learning.side_by_side import at_a_time, side_by_side
from pipeline.storage import zarrs
from pipeline.storage.artefacts import write_json, writing
from pipeline.storage.positions import error_by_frame, target_by_frame
from pipeline.storage.repeats import finished, publish
from pipeline.storage.scratch import digest_files
from pipeline.storage.stage import entry
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.params import VaeParams, VaeSizes
from pipeline.worldmodel.pictures import read_pictures, require_pictures
from pipeline.worldmodel.probes import Labelled, label, probe
from pipeline.worldmodel.reconstructions import write_reconstructions
from pipeline.worldmodel.vae_training import fit

READ = ("tip", "target_pixels", "target_pixels_free")


def main(*, frames: Path, out: Path, metrics: Path, picture: Path) -> None:
    """Writes ``out/repeat_{r}.pt``, the metrics, and repeat 0's held-out reconstructions."""
    store = zarrs.Store(frames, zarrs.FRAMES, "frames")
    place = set_up_torch()
    sizes = params.budget_section(VaeSizes, "vae", str(store.attributes["scene"]))
    require_pictures(store, sizes.frame_stride, at_a_time(store.repeats))
    results = side_by_side(lambda repeat: train_repeat(store, repeat, place), store.repeats)
    publish(out, metrics, store.attributes, results, "vae")
    with writing(picture) as aside:
        shutil.copyfile(results[0] / "reconstructions.png", aside)


def train_repeat(store: zarrs.Store, repeat: int, place: Compute) -> Path:
    """The scratch folder of a repeat's finished ``weights.pt``, ``metrics.json``, ``reconstructions.png``."""
    scene = str(store.attributes["scene"])
    method, sizes = params.section(VaeParams, "vae"), params.budget_section(VaeSizes, "vae", scene)
    share, seed = params.heldout_share(), params.seed()

    def make(results: Path, running: Path) -> None:
        arrays = {name: store.repeat(name, repeat) for name in READ}
        arrays |= {"target": target_by_frame(store, repeat), "error": error_by_frame(store, repeat)}
        training, heldout = split_episodes(len(arrays["tip"]), share)
        draws, what = seeds.integer(seed, repeat, Stream.VAE), f"vae, repeat {repeat}"
        seen, unseen = (
            read_pictures(store, repeat, part, sizes.frame_stride) for part in (training, heldout)
        )
        vae, numbers = fit(seen, unseen, method, sizes, place, draws, running, what)
        encoder = Encoder(vae, place)

        def labelled(pictures: np.ndarray, episodes: np.ndarray) -> Labelled:
            kept = (arrays[n][episodes, :: sizes.frame_stride] for n in ("tip", "target", "error"))
            return label(encoder(pictures), *kept)

        probing = seeds.integer(seed, repeat, Stream.PROBES)
        numbers |= probe(labelled(seen, training), labelled(unseen, heldout), method.probes, probing)
        shares = arrays["target_pixels"] / np.maximum(arrays["target_pixels_free"], 1)[:, None]
        hidden = arrays["target_pixels"] == 0
        numbers |= {"target_seen_share": shares.mean(), "frames_target_hidden_share": hidden.mean()}
        write_reconstructions(results / "reconstructions.png", vae, read_pictures(store, repeat, heldout))
        checkpoints.save(results / "weights.pt", vae.cpu().state_dict())
        write_json(results / "metrics.json", numbers)

    cache_key: dict[str, Any] = {"inputs": digest_files([store.place(repeat)]), "code": code_digest("vae")}
    cache_key |= {"method": method.model_dump(), "sizes": sizes.model_dump(), "machine": place.facts()}
    return finished("vae", repeat, make, seed=seed, heldout_share=share, **cache_key)


if __name__ == "__main__":
    entry(main)
