from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract import params
from pipeline.control.anchors import believing, expert, nothing, play
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds, target_paths

SCENES = tuple(params.value("scenes"))
EPISODES = 48


@pytest.mark.parametrize("name", SCENES)
def test_the_expert_reaches_the_targets(name: str) -> None:
    scene = load_scene(name)
    worlds, episodes = Worlds(scene, EPISODES), draw_episodes(scene, EPISODES, np.random.default_rng(4))
    tip_m, reward, error_m = play(worlds, episodes, expert(scene))
    distance = np.linalg.norm(tip_m - episodes.target_m[:, None], axis=2)
    np.testing.assert_allclose(reward, -distance[:, 1:], atol=1e-9)
    np.testing.assert_array_equal(reward, -error_m[:, 1:])
    assert (distance[:, -1] < 0.02).mean() >= 0.99


def test_doing_nothing_stays_where_it_starts() -> None:
    scene = load_scene("panda_1dof")
    worlds, episodes = Worlds(scene, 4), draw_episodes(scene, 4, np.random.default_rng(4))
    tip_m = play(worlds, episodes, nothing).tip_m
    assert np.linalg.norm(tip_m - episodes.start_m[:, None], axis=2).max() < 0.01


def test_who_believes_what_is_true_does_what_the_expert_does() -> None:
    scene = load_scene("panda_2dof_obstacle")
    worlds, episodes = Worlds(scene, 4), draw_episodes(scene, 4, np.random.default_rng(4))
    informed = believing(scene, target_paths(scene, episodes))
    ways = [play(worlds, episodes, policy).tip_m for policy in (informed, expert(scene))]
    np.testing.assert_array_equal(*ways)


def test_an_obstacle_stops_who_pushes_straight_on_and_not_the_expert() -> None:
    scene = load_scene("panda_2dof_obstacle")
    low = [
        candidate
        for candidate in scene.params.target.candidates_m
        if candidate[2] < scene.params.obstacles[0].center_m[2] * 2
    ]
    sides = np.array([sorted(low, key=lambda c: c[1])[i] for i in (0, -1)])
    assert sides[0, 1] < scene.params.obstacles[0].center_m[1] < sides[1, 1]
    episodes = Episodes.at(sides, sides[::-1].copy())
    worlds = Worlds(scene, 2)
    axes = list(scene.axes)

    def straight(worlds: Worlds, frame: int) -> np.ndarray:
        return np.clip((worlds.target - worlds.tip)[:, axes] / scene.params.displacement_m, -1.0, 1.0)

    stopped = play(worlds, episodes, straight).tip_m
    passed = play(worlds, episodes, expert(scene)).tip_m
    assert np.linalg.norm(stopped[:, -1] - episodes.target_m, axis=1).min() > 0.05
    assert np.linalg.norm(passed[:, -1] - episodes.target_m, axis=1).max() < 0.02
