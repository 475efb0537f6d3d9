"""Pictures between NumPy bytes and a network's folded tensors."""

from __future__ import annotations

import math

import numpy as np
import torch
from torch import Tensor

from pipeline.contract import memory, params
from pipeline.storage import zarrs
from pipeline.storage.parts import places

_EPISODES = 8  # read at a time; while it reads, Zarr holds about three times as much


def read_pictures(store: zarrs.Store, repeat: int, episodes: np.ndarray, stride: int = 1) -> np.ndarray:
    """Bytes (n, 64, 64, 3) of every ``stride``-th picture of some episodes.

    Args:
        store: of layout :data:`pipeline.storage.zarrs.FRAMES`.
        repeat: which of the store's.
        episodes: consecutive ones, ascending.
        stride: frames.
    """
    frames, *picture = store.shape("rgb")[1:]
    found = np.empty((len(episodes), -(-frames // stride), *picture), np.uint8)
    for place in places(len(episodes), _EPISODES):
        at = slice(episodes[place.start], episodes[place.stop - 1] + 1)
        found[place] = store.episodes("rgb", repeat, at)[:, ::stride]
    return found.reshape(-1, *picture)


def require_pictures(store: zarrs.Store, stride: int, at_a_time: int) -> None:
    """Refuses to train on more pictures than fit into memory, as read and folded, of so many repeats.

    Raises:
        BelvedereError: they need more memory than there is.
    """
    episodes, frames, *picture = store.shape("rgb")
    each = at_a_time * episodes * 2 * math.prod(picture)  # of every episode one picture

    def remedy(there: int) -> str:
        if each > there:
            return "not one picture of each episode fits; lower rollouts.episodes"
        return f"from {-(-frames // (there // each))} up it fits"

    place = f"{params.PARAMS_FILE}: budgets.{params.budget()}.vae.frame_stride"
    what = f"{place} = {stride}, of {episodes} episodes of {frames} frames, {at_a_time} repeat(s) at a time,"
    memory.require(each * -(-frames // stride), what, remedy)


def fold(pictures: np.ndarray | Tensor) -> Tensor:
    """Folds bytes (n, 64, 64, 3) to (n, 32, 32, 12): 2 × 2 pixels become 12 channels of one place.

    The channel order is that of ``torch.pixel_unshuffle``: colour, row, column.
    """
    bytes_ = torch.as_tensor(pictures)
    count, rows, columns, colours = bytes_.shape
    blocks = bytes_.reshape(count, rows // 2, 2, columns // 2, 2, colours)
    return blocks.permute(0, 1, 3, 5, 2, 4).reshape(count, rows // 2, columns // 2, 4 * colours)


def blocks(folded_pictures: Tensor) -> Tensor:
    """Folded pictures (n, 12, 32, 32) as 4 × 4 blocks of pixels (n, 16, 16, 2, 24).

    Each block is two rows of two folded places. It is a view of what lies channels last.
    """
    rows = folded_pictures.permute(0, 2, 3, 1).unflatten(2, (16, 2)).unflatten(1, (16, 2))
    return rows.permute(0, 1, 3, 2, 4, 5).flatten(4)


def folded(blocked: Tensor) -> Tensor:
    """Folded pictures (n, 12, 32, 32) of blocks (n, 16, 16, 2, 24)."""
    rows = blocked.permute(0, 1, 3, 2, 4)
    return rows.reshape(len(blocked), 32, 32, 12).permute(0, 3, 1, 2)


def unfold(folded_pictures: Tensor) -> np.ndarray:
    """Bytes (n, 64, 64, 3) of folded pictures (n, 12, 32, 32) in [0, 1]."""
    pixels = torch.pixel_shuffle(folded_pictures.float(), 2).mul(255).round().clamp(0, 255)
    return pixels.to(torch.uint8).permute(0, 2, 3, 1).cpu().numpy()


def floats(folded_bytes: Tensor) -> Tensor:
    """Folded bytes (n, h, w, c) as numbers (n, c, h, w) in [0, 1], channels last."""
    return folded_bytes.permute(0, 3, 1, 2).to(torch.float32).mul_(1 / 255)
