"""The batch of worlds as stable-baselines3's vectorised environment: the same task, no copy of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvObs, VecEnvStepReturn

from pipeline.contract.viewpoints import Viewpoint
from pipeline.qlearning.actions import action_table
from pipeline.rendering.renderer import Renderer
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds


def dqn_reward(reward: np.ndarray) -> np.ndarray:
    """Paper eq. (3) from eq. (1): 1 - 2 · error, clipped to [-1, 1]."""
    return np.clip(2.0 * reward + 1.0, -1.0, 1.0)


class Pictures:
    """One picture per world, drawn by several threads, each with worlds of its own."""

    def __init__(self, scene: Scene, view: Viewpoint, count: int, threads: int) -> None:
        self._parts = [part for part in np.array_split(np.arange(count), threads) if len(part)]
        self._images = [Renderer(scene, view, len(part)) for part in self._parts]
        self._pool = ThreadPoolExecutor(len(self._parts))
        self._rgb = np.zeros((count, PICTURE_SIZE, PICTURE_SIZE, 3), np.uint8)

    def __call__(self, worlds: Worlds) -> np.ndarray:
        """Pictures (count, 64, 64, 3) of the worlds as they are, in memory of their own."""
        qpos, target = worlds.qpos, worlds.target

        def draw(index: int) -> None:
            part = self._parts[index]
            self._rgb[part] = self._images[index].render(qpos[part], target[part])

        list(self._pool.map(draw, range(len(self._parts))))
        return self._rgb.copy()


class TaskEnv(VecEnv):
    """Worlds of one scene, seen from one viewpoint; all their episodes begin and end together.

    The limit of frames is truncation, not termination: an episode's last picture comes as
    ``terminal_observation`` with ``TimeLimit.truncated``, beside the next one's first.

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        count: how many worlds.
        rng: draws episodes.
        threads: how many cores draw and step.

    Attributes:
        returns: paper eq. (2) of the episodes that have ended, one array (count,) for each time.
    """

    def __init__(
        self, scene: Scene, view: Viewpoint, count: int, rng: np.random.Generator, threads: int
    ) -> None:
        self._scene, self._rng = scene, rng
        self._actions = action_table(scene.action_size)
        self._worlds = Worlds(scene, count, threads)
        self._pictures = Pictures(scene, view, count, threads)
        self._chosen = np.zeros(count, np.int64)
        self._frame, self._returned = 0, np.zeros(count)
        self.returns: list[np.ndarray] = []
        shape = (PICTURE_SIZE, PICTURE_SIZE, 3)
        super().__init__(count, spaces.Box(0, 255, shape, np.uint8), spaces.Discrete(len(self._actions)))

    @property
    def frames(self) -> int:
        """Frames of an episode."""
        return self._scene.frames

    def reset(self) -> VecEnvObs:
        self._worlds.reset(draw_episodes(self._scene, self.num_envs, self._rng))
        self._frame, self._returned = 0, np.zeros(self.num_envs)
        return self._pictures(self._worlds)

    def step_async(self, actions: np.ndarray) -> None:
        self._chosen = np.asarray(actions).reshape(self.num_envs)

    def step_wait(self) -> VecEnvStepReturn:
        reached = self._worlds.step(self._actions[self._chosen])
        self._frame, self._returned = self._frame + 1, self._returned + reached
        pictures = self._pictures(self._worlds)
        infos: list[dict[str, Any]] = [{"TimeLimit.truncated": False} for _ in range(self.num_envs)]
        over = self._frame == self._scene.frames
        if over:
            self.returns.append(self._returned)
            infos = [{"TimeLimit.truncated": True, "terminal_observation": last} for last in pictures]
            pictures = np.asarray(self.reset())
        return pictures, dqn_reward(reached).astype(np.float32), np.full(self.num_envs, over), infos

    def close(self) -> None:
        pass

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        value = None if attr_name == "render_mode" else getattr(self, attr_name)
        return [value for _ in self._chosen_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        raise NotImplementedError("the worlds share everything; nothing can be set for one of them")

    def env_method(
        self, method_name: str, *method_args: Any, indices: VecEnvIndices = None, **method_kwargs: Any
    ) -> list[Any]:
        raise NotImplementedError("the worlds are one batch; none has methods of its own")

    def env_is_wrapped(self, wrapper_class: type, indices: VecEnvIndices = None) -> list[bool]:
        return [False for _ in self._chosen_indices(indices)]

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Does nothing: episodes come from the generator that was passed in."""
        return [None] * self.num_envs

    def _chosen_indices(self, indices: VecEnvIndices) -> Iterable[int]:
        return self._get_indices(indices)
