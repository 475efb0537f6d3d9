"""Random episodes: actions that hang together in time, so that the tip covers the workspace."""

from __future__ import annotations

import numpy as np

from pipeline.contract.machine import cores
from pipeline.contract.progress import Progress
from pipeline.sim.draws import draw_episodes
from pipeline.sim.params import ExplorationParams
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds

# Numbers are kept to about a millionth of a radian or metre: what processors compute differently lies far
# below, so that a newcomer's machine draws the very bytes from which the committed results come.
_GRID = 2.0**-20


def correlated_actions(
    shape: tuple[int, int, int], process: ExplorationParams, rng: np.random.Generator
) -> np.ndarray:
    """Actions (episode, frame, axis) in [-1, 1], float32, from the stationary process, clipped."""
    noise = rng.standard_normal(shape)
    fresh = np.sqrt(1.0 - process.correlation**2)
    actions = np.empty(shape)
    actions[:, 0] = noise[:, 0]
    for t in range(1, shape[1]):
        actions[:, t] = process.correlation * actions[:, t - 1] + fresh * noise[:, t]
    return np.clip(process.deviation * actions, -1.0, 1.0).astype(np.float32)


def roll(
    scene: Scene, episodes: int, process: ExplorationParams, rng: np.random.Generator, progress: Progress
) -> dict[str, np.ndarray]:
    """One repeat's episodes: arrays of the rollouts layout."""
    drawn = draw_episodes(scene, episodes, rng)
    actions = correlated_actions((episodes, scene.frames, scene.action_size), process, rng)
    worlds = Worlds(scene, episodes, cores())
    worlds.reset(drawn)
    own = ("target_path", "error") if scene.task.own_arrays else ()
    frames: dict[str, list[np.ndarray]] = {name: [] for name in ("qpos", "tip", "reward", *own)}
    for t in range(scene.frames):
        frames["qpos"].append(worlds.qpos)
        frames["tip"].append(worlds.tip)
        if own:
            frames["target_path"].append(worlds.target)
            frames["error"].append(scene.task.gap(worlds.point, worlds.target))
        frames["reward"].append(worlds.step(actions[:, t]))
        progress.advance()
    stacked = {name: np.round(np.stack(values, axis=1) / _GRID) * _GRID for name, values in frames.items()}
    return {**stacked, "action": actions, "target": drawn.target_m}
