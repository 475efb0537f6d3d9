"""Stores for tests, written from arrays whose first axis is the repeat."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.storage import zarrs


def write_store(
    path: Path, schema: zarrs.Schema, arrays: Mapping[str, np.ndarray], attributes: Mapping[str, Any]
) -> None:
    """Writes a store with as many repeats as the arrays have."""
    for repeat in range(len(next(iter(arrays.values())))):
        of_repeat = {name: array[repeat] for name, array in arrays.items()}
        zarrs.write(zarrs.place(path, repeat), schema, of_repeat, attributes)


def random_frames(path: Path, episodes: int, frames: int) -> zarrs.Store:
    """A store of one repeat whose pictures and numbers mean nothing."""
    rng, sizes = np.random.default_rng(1), {"axis": 2, "row": 64, "column": 64, "channel": 3, "xyz": 3}
    sizes |= {"episode": episodes, "frame": frames}
    shapes = {name: [sizes[dim] for dim in column.dims] for name, column in zarrs.FRAMES.items()}
    arrays = {name: rng.integers(0, 256, (1, *shape), np.uint8) for name, shape in shapes.items()}
    write_store(path, zarrs.FRAMES, arrays, {})
    return zarrs.Store(path, zarrs.FRAMES, "frames")
