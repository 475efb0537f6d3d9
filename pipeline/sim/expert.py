"""State feedback that reaches every target, over obstacles: it is told positions and sees no pictures."""

from __future__ import annotations

import numpy as np

from pipeline.sim.boxes import crosses
from pipeline.sim.scene import Scene

_UP = 2
_REACHED_M = 0.01


class Expert:
    """Aims at the target where the straight way is clear; else up, over the obstacle, and down.

    An action asks for all of the way that remains, up to the largest displacement. The tip keeps an
    obstacle's clearance, in which there is neither start nor target.
    """

    def __init__(self, scene: Scene) -> None:
        self._axes, self._step_m = list(scene.axes), scene.params.displacement_m
        boxes, margin = scene.params.obstacles, scene.params.obstacle_clearance_m
        self._low = np.array([np.subtract(b.center_m, b.half_size_m) - margin for b in boxes]).reshape(-1, 3)
        self._high = np.array([np.add(b.center_m, b.half_size_m) + margin for b in boxes]).reshape(-1, 3)

    def __call__(self, tip_m: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """Actions (n, action_size) at tips (n, 3) and targets (n, 3)."""
        way = (self.waypoint(tip_m, target_m) - tip_m)[:, self._axes]
        return np.asarray(np.clip(way / self._step_m, -1.0, 1.0))

    def waypoint(self, tip_m: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """Where to aim now: shapes (n, 3), (n, 3) → (n, 3), m."""
        aim = target_m.copy()
        for low, high in zip(self._low, self._high, strict=True):
            blocked = crosses(tip_m, aim, low, high)
            above = tip_m[:, _UP] > high[_UP] - _REACHED_M
            over = np.where(above[:, None], aim, tip_m)
            over[:, _UP] = np.maximum(high[_UP], over[:, _UP])
            aim = np.where(blocked[:, None], over, aim)
        return aim
