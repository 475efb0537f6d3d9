"""State feedback that does every task, over obstacles: it is told positions and sees no pictures."""

from __future__ import annotations

import numpy as np

from pipeline.sim.boxes import crosses
from pipeline.sim.scene import Scene
from pipeline.sim.tasks.base import State

_UP = 2
_REACHED_M = 0.01


class Expert:
    """Goes where the task aims where the straight way is clear; else up, over the obstacle, and down.

    An action asks for all of the way that remains, up to the largest displacement. The tip keeps an
    obstacle's clearance, in which there is neither start nor target.
    """

    def __init__(self, scene: Scene) -> None:
        self._task = scene.task
        self._axes, self._step_m = list(scene.axes), scene.params.displacement_m
        boxes, margin = scene.params.obstacles, scene.params.obstacle_clearance_m
        self._low = np.array([np.subtract(b.center_m, b.half_size_m) - margin for b in boxes]).reshape(-1, 3)
        self._high = np.array([np.add(b.center_m, b.half_size_m) + margin for b in boxes]).reshape(-1, 3)

    def __call__(self, state: State) -> np.ndarray:
        """Actions (n, action_size) in the state of n worlds."""
        way = (self.waypoint(state) - state.tip_m)[:, self._axes]
        return np.asarray(np.clip(way / self._step_m, -1.0, 1.0))

    def waypoint(self, state: State) -> np.ndarray:
        """Where to go now, (n, 3), m: where the task aims, or first over an obstacle."""
        aim, tip_m = self._task.aim(state).copy(), state.tip_m
        for low, high in zip(self._low, self._high, strict=True):
            blocked = crosses(tip_m, aim, low, high)
            above = tip_m[:, _UP] > high[_UP] - _REACHED_M
            over = np.where(above[:, None], aim, tip_m)
            over[:, _UP] = np.maximum(high[_UP], over[:, _UP])
            aim = np.where(blocked[:, None], over, aim)
        return aim
