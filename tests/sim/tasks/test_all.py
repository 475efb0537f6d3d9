"""Laws of every task: draws in range and repeatable, an error of nought where it is done, and one expert."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.environment import environment
from pipeline.sim.expert import Expert
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds, target_paths
from tests.examples import KINDS, example

COUNT = 5


@pytest.fixture(params=KINDS)
def scene(request: pytest.FixtureRequest) -> Scene:
    return example(request.param)


def run(scene: Scene, episodes: Episodes, actions: np.ndarray, threads: int = 1) -> dict[str, np.ndarray]:
    worlds = Worlds(scene, len(episodes), threads)
    worlds.reset(episodes)
    seen: dict[str, list[np.ndarray]] = {name: [] for name in ("reward", "point", "target", "qpos")}
    for t in range(actions.shape[1]):
        seen["reward"].append(worlds.step(actions[:, t]))
        for name in ("point", "target", "qpos"):
            seen[name].append(getattr(worlds, name))
    return {name: np.stack(values, axis=1) for name, values in seen.items()}


def drawn(scene: Scene, seed: int, count: int = COUNT) -> tuple[Episodes, np.ndarray]:
    rng = np.random.default_rng(seed)
    return draw_episodes(scene, count, rng), rng.uniform(-1, 1, (count, scene.frames, scene.action_size))


def test_starts_and_targets_are_drawn_in_their_ranges(scene: Scene) -> None:
    episodes, axes = drawn(scene, 1, 300)[0], list(scene.axes)
    start = scene.params.start
    assert (episodes.start_m[:, axes] >= np.array(start.low_m)[axes]).all()
    assert (episodes.start_m[:, axes] <= np.array(start.high_m)[axes]).all()
    assert (
        np.ptp(episodes.start_m[:, axes], axis=0) > 0.9 * np.ptp([start.low_m, start.high_m], axis=0)[axes]
    ).all()
    candidates = np.array(scene.params.target.candidates_m)
    assert {tuple(row) for row in episodes.target_m} == {tuple(row) for row in candidates}
    goal = episodes.target_m + scene.task.offset_m
    others = [axis for axis in range(3) if axis not in axes]
    np.testing.assert_allclose(episodes.start_m[:, others], goal[:, others], atol=1e-12)


def test_the_same_generator_draws_the_same_and_the_worlds_do_the_same(scene: Scene) -> None:
    (first, actions), (second, _) = drawn(scene, 2), drawn(scene, 2)
    for name in ("start_m", "target_m", "drawn"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    one, two = (run(scene, first, actions, threads) for threads in (1, 2))
    for name, values in one.items():
        np.testing.assert_array_equal(values, two[name])


def test_the_error_is_nought_where_the_task_is_done_and_grows_with_the_way(scene: Scene) -> None:
    episodes, _ = drawn(scene, 3)
    target = target_paths(scene, episodes)[:, 0]
    goal = target + scene.task.offset_m
    assert not scene.task.error(goal, target).any()
    for axis in range(3):
        moved = goal + 0.03 * np.eye(3)[axis]
        np.testing.assert_allclose(
            scene.task.error(moved, target), 0.03 * scene.task.counted[axis], atol=1e-12
        )


def test_the_reward_is_minus_the_error(scene: Scene) -> None:
    found = run(scene, *drawn(scene, 4))
    np.testing.assert_allclose(
        found["reward"], -scene.task.error(found["point"], found["target"]), rtol=1e-12
    )
    gap = scene.task.gap(found["point"], found["target"])
    np.testing.assert_allclose(found["reward"], -np.linalg.norm(gap, axis=-1), rtol=1e-12)


def test_a_single_episode_is_the_batchs_to_the_bit(scene: Scene) -> None:
    """Under the expert, so that the puck is touched."""
    episodes, expert = drawn(scene, 5, 3)[0], Expert(scene)
    worlds, rewards, actions = Worlds(scene, 3), [], []
    worlds.reset(episodes)
    for _ in range(scene.frames):
        actions.append(expert(worlds.state))
        rewards.append(worlds.step(actions[-1]))
    env = environment(scene, np.random.default_rng(0))
    for world in range(3):
        env.task.start_with(episodes[np.array([world])])
        env.reset()
        for t in range(scene.frames):
            step = env.step(actions[t][world])
            assert step.reward == rewards[t][world]
        np.testing.assert_array_equal(step.observation["target_m"], worlds.target[world])


def test_success_is_declared_by_the_task_and_what_is_far_is_none(scene: Scene) -> None:
    near = scene.task.succeeded(np.zeros((1, scene.frames + 1)), 0.02)
    assert near[0, -1] and near.any()
    assert not scene.task.succeeded(np.full((1, scene.frames + 1), 0.03), 0.02).any()
