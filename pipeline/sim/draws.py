"""Episodes' starts and targets, drawn per scene and never per viewpoint."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.sim.scene import Scene

_ROUNDS = 200
_SAME_M = 1e-6


@dataclass(frozen=True, eq=False)
class Episodes:
    """Where episodes start and what they aim at.

    Attributes:
        start_m: tip positions, shape (n, 3), m, world frame.
        target_m: target positions, shape (n, 3), m, world frame; of one that moves, where it moves about.
        drawn: what the task draws beside them, shape (n, its ``drawn_size``).
    """

    start_m: np.ndarray
    target_m: np.ndarray
    drawn: np.ndarray

    @staticmethod
    def at(start_m: np.ndarray, target_m: np.ndarray) -> Episodes:
        """Episodes of a task that draws nothing else."""
        return Episodes(start_m, target_m, np.zeros((len(start_m), 0)))

    @staticmethod
    def joined(parts: Sequence[Episodes]) -> Episodes:
        """All episodes of all parts."""
        names = [field.name for field in fields(Episodes)]
        return Episodes(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    def __len__(self) -> int:
        return len(self.start_m)

    def __getitem__(self, index: slice | np.ndarray) -> Episodes:
        return Episodes(self.start_m[index], self.target_m[index], self.drawn[index])

    def tiled(self, times: int) -> Episodes:
        """All episodes, ``times`` times over: 0 1 2 0 1 2 …"""
        return Episodes.joined([self] * times)


def draw_episodes(scene: Scene, count: int, rng: np.random.Generator) -> Episodes:
    """Draws ``count`` episodes.

    Target: the candidates in equal shares (in random order), each moved by a uniform jitter on the
    controlled axes. Start: uniform in the start range on the controlled axes, at the task's goal on the
    others, which is the target's place or above it, so that it can be reached with the controlled axes
    alone (paper IV-A). Then what the task draws. Episodes that begin or end within an obstacle's
    clearance, or that the task does not accept, are drawn again. What a camera sees of them plays no part,
    so that no viewpoint is favoured.
    """
    if count < 1:
        raise BelvedereError(f"{count} episodes were asked for in scene {scene.name}; at least 1 is needed.")
    candidates = np.asarray(scene.params.target.candidates_m)
    middles = candidates[rng.permutation(np.arange(count) % len(candidates))]
    start, target = np.zeros((count, 3)), np.zeros((count, 3))
    drawn = np.zeros((count, scene.task.drawn_size))
    pending = np.arange(count)
    for _ in range(_ROUNDS):
        start[pending], target[pending] = _propose(scene, middles[pending], rng)
        drawn[pending] = scene.task.draw(scene.params, start[pending], target[pending], rng)
        fine = _clear(scene, start[pending]) & _clear(scene, target[pending])
        fine &= scene.task.acceptable(start[pending], target[pending], drawn[pending])
        pending = pending[~fine]
        if not len(pending):
            return Episodes(start, target, drawn)
    raise BelvedereError(
        f"scene {scene.name}: no acceptable start for target candidate {middles[pending[0]].tolist()} m was "
        f"found in {_ROUNDS} draws; widen scenes.{scene.name}.start in params.yaml or move its obstacles."
    )


def _propose(scene: Scene, middles: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    controlled = np.isin(np.arange(3), scene.axes)
    jitter = np.asarray(scene.params.target.jitter_m)
    target = middles + controlled * jitter * rng.uniform(-1.0, 1.0, middles.shape)
    low, high = _lowest_starts(scene, target), np.asarray(scene.params.start.high_m)
    start = low + rng.uniform(0.0, 1.0, middles.shape) * (high - low)
    return np.where(controlled, start, target + scene.task.offset_m), target


def start_density(scene: Scene, start: np.ndarray, target: np.ndarray) -> np.ndarray:
    """How likely starts (n, 3) are with targets (m, 3), up to a factor: (n, m).

    It is the density from which :func:`draw_episodes` draws, but for obstacles that leave some targets
    more of the start range than others.
    """
    others = [axis for axis in range(3) if axis not in scene.axes]
    goal = target + scene.task.offset_m
    same = np.isclose(start[:, None, others], goal[None, :, others], rtol=0.0, atol=_SAME_M).all(axis=2)
    low, high = _lowest_starts(scene, target), np.asarray(scene.params.start.high_m)
    axes = list(scene.axes)
    above = (start[:, None, axes] >= low[None, :, axes] - _SAME_M).all(axis=2)
    return np.asarray(same * above / np.maximum(high - low, _SAME_M)[:, axes].prod(axis=1))


def _lowest_starts(scene: Scene, target: np.ndarray) -> np.ndarray:
    """The lower ends of the ranges from which starts are drawn: (n, 3)."""
    start = scene.params.start
    low = np.repeat(np.array([start.low_m]), len(target), axis=0)
    if start.above_target_m is not None:
        low[:, 2] = np.clip(target[:, 2] + start.above_target_m, low[:, 2], start.high_m[2])
    return low


def _clear(scene: Scene, points: np.ndarray) -> np.ndarray:
    clear = np.ones(len(points), bool)
    for box in scene.params.obstacles:
        gap = np.abs(points - np.asarray(box.center_m)) - np.asarray(box.half_size_m)
        clear &= (gap >= scene.params.obstacle_clearance_m).any(axis=1)
    return clear
