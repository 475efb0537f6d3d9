"""Episodes' starts and targets, drawn per scene and never per viewpoint."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.sim.camera import viewpoint
from pipeline.sim.drives import drive
from pipeline.sim.scene import Scene
from pipeline.sim.sight import Sight

_ROUNDS = 200


@dataclass(frozen=True, eq=False)
class Episodes:
    """Where episodes start and what they aim at.

    Attributes:
        start_m: tip positions, shape (n, 3), m, world frame.
        target_m: target positions, shape (n, 3), m, world frame.
    """

    start_m: np.ndarray
    target_m: np.ndarray

    def __len__(self) -> int:
        return len(self.start_m)

    def __getitem__(self, index: slice | np.ndarray) -> Episodes:
        return Episodes(self.start_m[index], self.target_m[index])

    def tiled(self, times: int) -> Episodes:
        """All episodes, ``times`` times over: 0 1 2 0 1 2 …"""
        return Episodes(np.tile(self.start_m, (times, 1)), np.tile(self.target_m, (times, 1)))


def draw_episodes(scene: Scene, count: int, rng: np.random.Generator) -> Episodes:
    """Draws ``count`` episodes.

    Target: the candidates in equal shares (in random order), each moved by a uniform jitter on the
    controlled axes. Start: uniform in the start range on the controlled axes, at the target's place
    on the others, so that the target can be reached with the controlled axes alone (paper IV-A).
    Episodes that begin within an obstacle's clearance, or with the target all but hidden from one of
    the scene's ``seen_from_deg`` directions, are drawn again. No viewpoint of a branch plays a part.
    """
    if count < 1:
        raise BelvedereError(f"{count} episodes were asked for in scene {scene.name}; at least 1 is needed.")
    candidates = np.asarray(scene.params.target.candidates_m)
    middles = candidates[rng.permutation(np.arange(count) % len(candidates))]
    start, target = np.zeros((count, 3)), np.zeros((count, 3))
    pending = np.arange(count)
    for _ in range(_ROUNDS):
        start[pending], target[pending] = _propose(scene, middles[pending], rng)
        pending = pending[~_acceptable(scene, start[pending], target[pending])]
        if not len(pending):
            return Episodes(start, target)
    raise BelvedereError(
        f"scene {scene.name}: no acceptable start for target candidate {middles[pending[0]].tolist()} m was "
        f"found in {_ROUNDS} draws; widen scenes.{scene.name}.start in params.yaml, move its obstacles, or "
        "enlarge its target."
    )


def _propose(scene: Scene, middles: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    controlled = np.isin(np.arange(3), scene.axes)
    start_range = scene.params.start
    jitter = np.asarray(scene.params.target.jitter_m)
    target = middles + controlled * jitter * rng.uniform(-1.0, 1.0, middles.shape)
    low = np.repeat(np.array([start_range.low_m]), len(middles), axis=0)
    high = np.asarray(start_range.high_m)
    if start_range.above_target_m is not None:
        low[:, 2] = np.clip(target[:, 2] + start_range.above_target_m, low[:, 2], high[2])
    start = low + rng.uniform(0.0, 1.0, middles.shape) * (high - low)
    return np.where(controlled, start, target), target


def _acceptable(scene: Scene, start: np.ndarray, target: np.ndarray) -> np.ndarray:
    fine = _clear(scene, start) & _clear(scene, target)
    if not fine.any() or not scene.params.target.seen_from_deg:
        return fine
    candidates = np.flatnonzero(fine)
    qpos = drive(scene, len(candidates), 1).reset(start[candidates], target[candidates])["qpos"]
    sight = Sight(scene, len(candidates))
    for theta, phi in scene.params.target.seen_from_deg:
        pixels = sight.target_pixels(viewpoint(scene.name, theta, phi), qpos, target[candidates])
        fine[candidates] &= pixels >= scene.params.target.seen_pixels
    return fine


def _clear(scene: Scene, points: np.ndarray) -> np.ndarray:
    clear = np.ones(len(points), bool)
    for box in scene.params.obstacles:
        gap = np.abs(points - np.asarray(box.center_m)) - np.asarray(box.half_size_m)
        clear &= (gap >= scene.params.obstacle_clearance_m).any(axis=1)
    return clear
