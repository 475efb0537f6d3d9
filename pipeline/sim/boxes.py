"""Axis-aligned boxes, and what passes through them."""

from __future__ import annotations

import numpy as np


def crosses(start: np.ndarray, end: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Whether segments (n, 3) to (n, 3) meet the inside of a box (slab method): (n,)."""
    way = end - start
    way = np.where(np.abs(way) < 1e-12, 1e-12, way)
    first, second = (low - start) / way, (high - start) / way
    enters = np.minimum(first, second).max(axis=1)
    leaves = np.maximum(first, second).min(axis=1)
    return np.asarray((enters < leaves) & (leaves > 0.0) & (enters < 1.0))
