"""The best that can be had without seeing the target: going to where it is expected to be least far."""

from __future__ import annotations

import numpy as np

from pipeline.sim.draws import draw_episodes, start_density
from pipeline.sim.scene import Scene

_TARGETS = 4096  # drawn to know how targets are spread
_ROUNDS = 1000
_ENOUGH_M = 1e-5


class TargetBlind:
    """Knows the tip and how a scene draws its episodes, never an episode's target.

    Nothing that happens in an episode tells of its target but where it starts. So what lies ahead costs
    least, frame by frame, at the place whose expected distance from the targets that go with that start
    is least: their geometric median, in one axis the median.
    """

    def __init__(self, scene: Scene, rng: np.random.Generator) -> None:
        self._scene = scene
        drawn = draw_episodes(scene, _TARGETS, rng).target_m
        self._targets, self._counts = np.unique(drawn, axis=0, return_counts=True)

    def goals(self, start_m: np.ndarray) -> np.ndarray:
        """Where to go from starts: (n, 3) → (n, 3), m; on the axes that are not controlled, nowhere."""
        axes, goals = list(self._scene.axes), start_m.copy()
        weights = self._counts * start_density(self._scene, start_m, self._targets)
        known = weights.sum(axis=1) > 0  # a start at the very edge may go with no target that was drawn
        goals[np.ix_(known, axes)] = geometric_median(self._targets[:, axes], weights[known])
        return goals


def geometric_median(points: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The places of least weighted mean distance from points (m, d), by rows of weights (n, m): (n, d).

    Weiszfeld's iteration (Weiszfeld 1937), from the weighted means.
    """
    result = weights @ points / weights.sum(axis=1, keepdims=True)
    for _ in range(_ROUNDS):
        away = np.linalg.norm(points - result[:, None], axis=2)
        pulls = weights / np.maximum(away, _ENOUGH_M)
        before, result = result, pulls @ points / pulls.sum(axis=1, keepdims=True)
        if np.abs(result - before).max(initial=0.0) < 0.01 * _ENOUGH_M:
            break
    return result
