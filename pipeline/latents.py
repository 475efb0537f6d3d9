"""Writes each picture of one viewpoint as its latent: the VAE's posterior of every frame."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract.source import code_digest
from pipeline.learning.device import Compute, set_up_torch
from pipeline.learning.side_by_side import side_by_side
from pipeline.storage import zarrs
from pipeline.storage.parts import places
from pipeline.storage.repeats import REPEAT, finished, publish_store
from pipeline.storage.scratch import digest_files
from pipeline.storage.stage import entry
from pipeline.worldmodel.encoder import BATCH, Encoder
from pipeline.worldmodel.vae import LATENTS, load_vae


def main(*, frames: Path, vae: Path, out: Path) -> None:
    """Encodes each repeat's frames with that repeat's network."""
    store = zarrs.Store(frames, zarrs.FRAMES, "frames")
    place = set_up_torch()
    publish_store(out, side_by_side(lambda r: encode_repeat(store, r, vae, place), store.repeats))


def encode_repeat(store: zarrs.Store, repeat: int, vae: Path, place: Compute) -> Path:
    """The scratch folder of a repeat's finished latents."""
    weights = vae / f"repeat_{repeat}.pt"
    network = load_vae(weights)

    def make(results: Path, running: Path) -> None:
        arrays = encode(store, repeat, Encoder(network, place))
        zarrs.write(results / REPEAT, zarrs.LATENTS, arrays, store.attributes)

    inputs = digest_files([store.place(repeat), weights])
    cache_key: dict[str, Any] = {"inputs": inputs, "code": code_digest("latents"), "machine": place.facts()}
    return finished("latents", repeat, make, **cache_key)


def encode(store: zarrs.Store, repeat: int, encoder: Encoder) -> dict[str, np.ndarray]:
    """One repeat's arrays of the latents layout."""
    same = {name: store.repeat(name, repeat) for name in ("action", "reward")}
    episodes, frames = same["reward"].shape
    mean, log_variance = (np.empty((episodes, frames, LATENTS), np.float32) for _ in range(2))
    whole = BATCH // math.gcd(BATCH, frames)  # episodes that fill batches, so that parts round as the whole
    for place in places(episodes, whole):
        rgb = store.episodes("rgb", repeat, place)
        latents = encoder.posterior(rgb.reshape(-1, *rgb.shape[2:]))
        mean[place], log_variance[place] = (part.numpy().reshape(-1, frames, LATENTS) for part in latents)
    return {"mean": mean, "log_variance": log_variance, **same}


if __name__ == "__main__":
    entry(main)
