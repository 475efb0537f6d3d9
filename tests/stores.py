"""Stores for tests, written from arrays whose first axis is the repeat."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from pipeline.contract import zarrs


def write_store(
    path: Path, schema: zarrs.Schema, arrays: Mapping[str, np.ndarray], attributes: Mapping[str, Any]
) -> None:
    """Writes a store with as many repeats as the arrays have."""
    for repeat in range(len(next(iter(arrays.values())))):
        of_repeat = {name: array[repeat] for name, array in arrays.items()}
        zarrs.write(zarrs.place(path, repeat), schema, of_repeat, attributes)
