"""A picture for people: what the VAE keeps of what it sees."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import torch
from PIL import Image

from pipeline.storage.artefacts import writing
from pipeline.worldmodel import pictures
from pipeline.worldmodel.vae import Vae

COLUMNS = 8
ENLARGEMENT = 2


def reconstructions(vae: Vae, heldout: np.ndarray) -> np.ndarray:
    """Pictures above their reconstructions.

    Args:
        vae: the network.
        heldout: bytes (n, 64, 64, 3); columns are taken evenly from first to last.

    Returns:
        Bytes (256, 1024, 3).
    """
    chosen = heldout[np.linspace(0, len(heldout) - 1, COLUMNS).round().astype(int)]
    with torch.inference_mode():
        device = next(vae.parameters()).device
        mean, _ = vae.encode_folded(pictures.floats(pictures.fold(chosen).to(device)))
        seen = pictures.unfold(pictures.folded(vae.decode_blocks(mean)))
    rows = [np.concatenate(list(row), axis=1) for row in (chosen, seen)]
    return np.concatenate(rows).repeat(ENLARGEMENT, axis=0).repeat(ENLARGEMENT, axis=1)


def write_reconstructions(path: Path, vae: Vae, heldout: np.ndarray) -> None:
    """Writes :func:`reconstructions` as PNG."""
    with writing(path) as aside:
        Image.fromarray(reconstructions(vae, heldout)).save(aside, format="PNG")
