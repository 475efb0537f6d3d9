"""Pictures between NumPy bytes and a network's folded tensors."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor


def fold(pictures: np.ndarray | Tensor) -> Tensor:
    """Folds bytes (n, 64, 64, 3) to (n, 32, 32, 12): 2 × 2 pixels become 12 channels of one place.

    The channel order is that of ``torch.pixel_unshuffle``: colour, row, column.
    """
    bytes_ = torch.as_tensor(pictures)
    count, rows, columns, colours = bytes_.shape
    blocks = bytes_.reshape(count, rows // 2, 2, columns // 2, 2, colours)
    return blocks.permute(0, 1, 3, 5, 2, 4).reshape(count, rows // 2, columns // 2, 4 * colours)


def blocks(folded_bytes: Tensor) -> Tensor:
    """Folded bytes (n, 32, 32, 12) as 4 × 4 blocks (n, 16, 16, 48), in ``torch.pixel_unshuffle``'s order."""
    count = len(folded_bytes)
    places = folded_bytes.reshape(count, 16, 2, 16, 2, 3, 2, 2).permute(0, 1, 3, 5, 2, 6, 4, 7)
    return places.reshape(count, 16, 16, 48)


def unfold(blocked: Tensor) -> np.ndarray:
    """Bytes (n, 64, 64, 3) of a decoder's blocks (n, 48, 16, 16) in [0, 1]."""
    pixels = torch.pixel_shuffle(blocked.float(), 4).mul(255).round().clamp(0, 255)
    return pixels.to(torch.uint8).permute(0, 2, 3, 1).cpu().numpy()


def floats(folded_bytes: Tensor) -> Tensor:
    """Folded bytes (n, h, w, c) as numbers (n, c, h, w) in [0, 1], channels last."""
    return folded_bytes.permute(0, 3, 1, 2).to(torch.float32).mul_(1 / 255)
