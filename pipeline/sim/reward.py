"""The reward: paper eq. (1). The return of an episode is the sum over its frames, eq. (2)."""

from __future__ import annotations

import numpy as np


def reach_reward(tip_m: np.ndarray, target_m: np.ndarray) -> np.ndarray:
    """Minus the distance from tip to target; shapes (n, 3), (n, 3) → (n,), m."""
    return np.asarray(-np.linalg.norm(target_m - tip_m, axis=-1))
