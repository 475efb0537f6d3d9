from __future__ import annotations

import numpy as np

from pipeline.sim.draws import draw_episodes
from pipeline.sim.expert import Expert
from pipeline.sim.scene import load_scene
from pipeline.sim.tasks.base import State

RNG = np.random.default_rng(6)


def told(tip_m: np.ndarray, target_m: np.ndarray) -> State:
    """The state of worlds in which the tip is to reach a target that rests."""
    return State(tip_m, tip_m, target_m, target_m)


def test_without_obstacles_it_aims_at_the_target_and_asks_for_no_more_than_can_be_had() -> None:
    scene = load_scene("panda_2dof")
    episodes = draw_episodes(scene, 32, RNG)
    expert = Expert(scene)
    begin = told(episodes.start_m, episodes.target_m)
    np.testing.assert_array_equal(expert.waypoint(begin), episodes.target_m)
    action = expert(begin)
    assert np.abs(action).max() <= 1.0
    way = (episodes.target_m - episodes.start_m)[:, list(scene.axes)]
    assert np.all(np.sign(action) == np.sign(way))
    assert not expert(told(episodes.target_m, episodes.target_m)).any()


def test_its_way_over_an_obstacle_keeps_clear_of_it_and_ends_at_the_target() -> None:
    """Followed by a point that does as it is told, in steps finer than the clearance."""
    scene = load_scene("panda_2dof_obstacle")
    box, clearance_m = scene.params.obstacles[0], scene.params.obstacle_clearance_m
    episodes, expert = draw_episodes(scene, 256, RNG), Expert(scene)
    point = episodes.start_m.copy()
    for _ in range(300):
        gap = np.abs(point - np.asarray(box.center_m)) - np.asarray(box.half_size_m)
        assert gap.max(axis=1).min() > 0.5 * clearance_m
        way = expert.waypoint(told(point, episodes.target_m)) - point
        length = np.linalg.norm(way, axis=1, keepdims=True)
        point += way * np.minimum(1.0, 0.005 / np.maximum(length, 1e-9))
    np.testing.assert_allclose(point, episodes.target_m, atol=1e-6)
