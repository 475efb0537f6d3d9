"""Writes each picture of one viewpoint as its code: the VAE's posterior of every frame."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pipeline.contract import zarrs
from pipeline.contract.stage import entry
from pipeline.learning.device import Compute, compute
from pipeline.learning.repeats import side_by_side
from pipeline.worldmodel.encoder import Encoder
from pipeline.worldmodel.vae import LATENTS, load_vae


def main(*, frames: Path, vae: Path, out: Path) -> None:
    """Encodes each repeat's frames with that repeat's network."""
    store = zarrs.Store(frames, zarrs.FRAMES, "frames")
    place = compute()
    encoded = side_by_side(lambda r: encode(store, r, vae / f"repeat_{r}.pt", place), store.repeats)
    arrays = {name: np.stack([each[name] for each in encoded]) for name in zarrs.LATENTS}
    attributes = {name: value for name, value in store.attributes.items() if name != "format"}
    zarrs.write(out, zarrs.LATENTS, arrays, attributes)


def encode(store: zarrs.Store, repeat: int, weights: Path, place: Compute) -> dict[str, np.ndarray]:
    """One repeat's columns of the store of latents."""
    rgb = store.repeat("rgb", repeat)
    mean, log_variance = Encoder(load_vae(weights), place).posterior(rgb.reshape(-1, *rgb.shape[2:]))
    shape = (*rgb.shape[:2], LATENTS)
    return {
        "mean": mean.numpy().reshape(shape),
        "log_variance": log_variance.numpy().reshape(shape),
        **{name: store.repeat(name, repeat) for name in ("action", "reward")},
    }


if __name__ == "__main__":
    entry(main)
