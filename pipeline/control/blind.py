"""The best that can be had without seeing the target: going to where it is expected to be least far."""

from __future__ import annotations

import numpy as np

from pipeline.control.anchors import Policy, believing
from pipeline.sim.draws import draw_episodes, start_density
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import target_paths

_TARGETS = 4096  # drawn to know how targets are spread
_ROUNDS = 1000
_ENOUGH_M = 1e-5


class TargetBlind:
    """Knows the tip and how a scene draws its episodes, never an episode's target, nor what else is drawn.

    Nothing that happens in an episode tells of its target but where it starts. So what lies ahead costs
    least, frame by frame, at the place whose expected distance from the targets that go with that start
    is least: their geometric median, in one axis the median. The expert is told that this is the target.
    """

    def __init__(self, scene: Scene, rng: np.random.Generator) -> None:
        self._scene, self._episodes = scene, draw_episodes(scene, _TARGETS, rng)
        self._axes = [axis for axis in scene.axes if scene.task.counted[axis]]

    def policy(self, start_m: np.ndarray) -> Policy:
        """The policy for episodes with these starts (n, 3), m."""
        return believing(self._scene, self.targets(start_m), self._scene.task.imagined(self._episodes.drawn))

    def targets(self, start_m: np.ndarray) -> np.ndarray:
        """Where it believes the targets of starts (n, 3) to be, by frame: (n, t + 1, 3), m.

        On axes that are not controlled or do not count they are where the tip has no way to go.
        """
        task, paths = self._scene.task, target_paths(self._scene, self._episodes)
        believed = np.repeat((start_m - task.offset_m)[:, None], paths.shape[1], axis=1)
        if not task.moves:  # where it rests it is looked for once
            paths = paths[:, :1]
        first, _, counts = _unlike(paths.reshape(len(paths), -1))
        weights = counts * start_density(self._scene, start_m, self._episodes.target_m[first])
        known = weights.sum(axis=1) > 0  # a start at the very edge may go with no target that was drawn
        medians = _medians(paths[first][:, :, self._axes], weights[known])
        for axis, values in zip(self._axes, np.moveaxis(medians, 2, 0), strict=True):
            believed[known, :, axis] = values  # (known, frames or 1)
        return believed


def _medians(paths_m: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Geometric medians of paths (m, t, d) at each time, by rows of weights (n, m): (n, t, d)."""
    if paths_m.shape[1] == 1:
        return geometric_median(paths_m[:, 0], weights)[:, None]
    rows, alike, _ = _unlike(weights)  # starts that tell the same of targets share their medians
    times = [geometric_median(places, weights[rows]) for places in paths_m.swapaxes(0, 1)]
    return np.stack(times, axis=1)[alike]


def _unlike(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of rows that are alike the first one, by number; of each row which that is; how many are alike."""
    _, first, where, counts = np.unique(
        rows, axis=0, return_index=True, return_inverse=True, return_counts=True
    )
    return first, where.reshape(-1), counts


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
