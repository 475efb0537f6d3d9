"""Follow: the target's path has the declared size and period, from a phase that is drawn."""

from __future__ import annotations

import numpy as np
from scipy import stats

from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import Worlds, target_paths
from tests.examples import example
from tests.sim.conftest import compile_changed


def with_task(**changed: object) -> Scene:
    params = example("follow").params
    tree = params.model_dump() | {"task": params.task.model_dump() | changed}
    return compile_changed("changed", type(params).model_validate(tree))


def test_the_target_has_the_declared_radius_and_period() -> None:
    scene = example("follow")
    frame_s = scene.params.substeps * scene.params.timestep_s
    episodes = draw_episodes(scene, 50, np.random.default_rng(1))
    path = target_paths(scene, episodes)
    radius = np.linalg.norm(path - episodes.target_m[:, None], axis=2)
    np.testing.assert_allclose(radius, scene.params.task.radius_m[1], atol=1e-12)
    frames = round(scene.params.task.period_s / frame_s)
    assert frames == 50
    np.testing.assert_allclose(path[:, frames], path[:, 0], atol=1e-12)
    assert np.linalg.norm(path[:, 1:frames] - path[:, :1], axis=2).min() > 0.01
    speed = np.linalg.norm(np.diff(path, axis=1), axis=2) / frame_s
    np.testing.assert_allclose(speed, 2 * np.pi * 0.09 / scene.params.task.period_s, rtol=0.01)


def test_half_the_period_is_gone_round_twice() -> None:
    path = target_paths(scene := with_task(period_s=1.0), draw_episodes(scene, 3, np.random.default_rng(1)))
    np.testing.assert_allclose(path[:, 25:], path[:, :26], atol=1e-12)


def test_unlike_cycles_are_a_figure_of_eight() -> None:
    scene = with_task(cycles=(1, 1, 2), phase_deg=(0.0, 0.0, 0.0))
    path = target_paths(scene, draw_episodes(scene, 1, np.random.default_rng(1)))[0] - (0.5, 0.0, 0.23)
    y, z = path[:, 1] / 0.09, path[:, 2] / 0.09
    np.testing.assert_allclose(z**2, 4 * y**2 * (1 - y**2), atol=1e-12)  # Lissajous' 1 : 2


def test_where_it_starts_is_drawn_uniformly() -> None:
    drawn = draw_episodes(example("follow"), 3000, np.random.default_rng(2)).drawn[:, 0]
    assert stats.kstest(drawn, stats.uniform(0, 2 * np.pi).cdf).pvalue > 0.001


def test_the_body_that_is_drawn_moves_with_it() -> None:
    scene, worlds = example("follow"), Worlds(example("follow"), 2)
    episodes = draw_episodes(scene, 2, np.random.default_rng(3))
    worlds.reset(episodes)
    path = target_paths(scene, episodes)
    for t in range(scene.frames):
        np.testing.assert_array_equal(worlds.target, path[:, t])
        np.testing.assert_array_equal(worlds.state.next_target_m, path[:, t + 1])
        worlds.step(np.zeros((2, 2)))
        np.testing.assert_array_equal(worlds._mocap[:, scene.target_mocap], path[:, t + 1])


def test_success_has_to_be_held() -> None:
    task = example("follow").task
    error = np.full((1, 40), 0.1)
    error[0, 5:14] = 0.01  # nine frames
    assert not task.succeeded(error, 0.02).any()
    error[0, 14] = 0.01
    assert np.flatnonzero(task.succeeded(error, 0.02)[0]).tolist() == [14]
