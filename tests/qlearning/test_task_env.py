"""The batch of worlds as stable-baselines3 sees it: against dm_control, and by the library's own rules."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
import pytest
from stable_baselines3.common.env_checker import check_env

from pipeline.contract.viewpoints import viewpoint
from pipeline.qlearning.actions import action_table
from pipeline.qlearning.task_env import TaskEnv, dqn_reward
from pipeline.rendering.renderer import Renderer
from pipeline.sim.draws import draw_episodes
from pipeline.sim.environment import environment
from pipeline.sim.scene import load_scene

COUNT = 3


def task_env(name: str, count: int = COUNT, seed: int = 5, threads: int = 2) -> TaskEnv:
    view = viewpoint(name, 20, 30)
    return TaskEnv(load_scene(name), view, count, np.random.default_rng(seed), threads)


class OneWorld(gymnasium.Env):
    """One world of the vectorised environment under gymnasium's own interface, for the library's checker."""

    def __init__(self) -> None:
        self._env = task_env("panda_2dof", count=1)
        self.observation_space, self.action_space = self._env.observation_space, self._env.action_space

    def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[np.ndarray, dict[str, Any]]:
        super().reset(seed=seed)
        if seed is not None:
            self._env._rng = np.random.default_rng(seed)
        return self._env.reset()[0], {}

    def step(self, action: int) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        pictures, rewards, dones, infos = self._env.step(np.array([action]))
        truncated = bool(dones[0])
        seen = infos[0]["terminal_observation"] if truncated else pictures[0]
        return seen, float(rewards[0]), False, truncated, {}


def test_the_librarys_checker_finds_nothing() -> None:
    check_env(OneWorld())


@pytest.mark.parametrize("name", ["panda_1dof", "fetch_reach"])
def test_rewards_and_pictures_are_those_of_the_dm_control_environment(name: str) -> None:
    scene, view = load_scene(name), viewpoint(name, 20, 30)
    env, table = task_env(name), action_table(scene.action_size)
    assert len(table) == env.action_space.n == 3**scene.action_size
    first = np.array(env.reset())
    episodes = draw_episodes(scene, COUNT, np.random.default_rng(5))  # what the environment drew
    chosen = np.random.default_rng(1).integers(len(table), size=(scene.frames, COUNT))
    steps = [env.step(actions) for actions in chosen]
    single, images = environment(scene, np.random.default_rng(0)), Renderer(scene, view, 1)
    for world in range(COUNT):
        one = np.array([world])
        single.task.start_with(episodes[one])
        step = single.reset()
        seen = images.render(single.physics.data.qpos.astype(np.float32)[None], episodes.target_m[one])
        np.testing.assert_array_equal(first[world], seen[0])
        for t in range(scene.frames):
            step = single.step(table[chosen[t, world]])
            assert steps[t][1][world] == np.float32(np.clip(1 + 2 * step.reward, -1, 1))
        last = images.render(single.physics.data.qpos.astype(np.float32)[None], episodes.target_m[one])
        np.testing.assert_array_equal(steps[-1][3][world]["terminal_observation"], last[0])


def test_episodes_are_cut_off_not_ended_and_begin_anew_at_once() -> None:
    env = task_env("panda_1dof")
    frames = env.frames
    env.reset()
    still = np.full(COUNT, 1)  # the middle of {-1, 0, 1}
    for t in range(2 * frames):
        pictures, rewards, dones, infos = env.step(still)
        over = t % frames == frames - 1
        assert pictures.shape == (COUNT, 64, 64, 3) and pictures.dtype == np.uint8
        assert rewards.dtype == np.float32 and (np.abs(rewards) <= 1).all()
        assert dones.tolist() == [over] * COUNT
        assert [info["TimeLimit.truncated"] for info in infos] == [over] * COUNT
        assert all(("terminal_observation" in info) == over for info in infos)
        if over:  # what is returned is the next episode's first picture
            assert any(
                (info["terminal_observation"] != p).any() for info, p in zip(infos, pictures, strict=True)
            )
    assert len(env.returns) == 2 and env.returns[0].shape == (COUNT,)


def test_a_returned_picture_is_not_drawn_over() -> None:
    env = task_env("panda_1dof")
    env.reset()
    first = env.step(np.zeros(COUNT, int))[0]
    kept = first.copy()
    env.step(np.full(COUNT, 2))
    np.testing.assert_array_equal(first, kept)


def test_threads_do_not_change_a_picture() -> None:
    one, two = (task_env("panda_2dof", threads=threads) for threads in (1, 2))
    np.testing.assert_array_equal(one.reset(), two.reset())
    for _ in range(3):
        actions = np.array([0, 4, 8])
        np.testing.assert_array_equal(one.step(actions)[0], two.step(actions)[0])


def test_the_reward_is_equation_3() -> None:
    distances = np.array([0.0, 0.25, 0.5, 1.0, 3.0])
    np.testing.assert_allclose(dqn_reward(-distances), [1.0, 0.5, 0.0, -1.0, -1.0])
