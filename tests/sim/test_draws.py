"""Episodes: what is drawn lies where it may, is seen, varies enough, and never depends on a viewpoint."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.sim.camera import viewpoint
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import Scene, compile_scene
from pipeline.sim.sight import Sight
from pipeline.sim.worlds import Worlds
from tests.sim.conftest import VIEWS, compiled

COUNT = 64


def test_target_is_seen_in_nine_pixels_from_every_candidate_at_every_reset(scene: Scene) -> None:
    episodes = draw_episodes(scene, COUNT, np.random.default_rng(0))
    worlds = Worlds(scene, COUNT)
    worlds.reset(episodes)
    sight = Sight(scene, COUNT)
    for view in VIEWS:
        if view.scene == scene.name:
            pixels = sight.target_pixels(view, worlds.qpos, episodes.target_m)
            assert pixels.min() >= 9, view


def test_draws_cover_most_of_the_workspace(scene: Scene) -> None:
    episodes = draw_episodes(scene, 256, np.random.default_rng(1))
    axes = list(scene.axes)
    workspace = (np.array(scene.params.workspace.high_m) - scene.params.workspace.low_m)[axes]
    assert (np.ptp(episodes.target_m[:, axes], axis=0) >= 0.6 * workspace).all()
    if scene.robot.drive == "joints":  # Fetch always starts at the same place
        assert (np.ptp(episodes.start_m[:, axes], axis=0) >= 0.6 * workspace).all()


def test_the_way_is_along_the_controlled_axes_alone(scene: Scene) -> None:
    episodes = draw_episodes(scene, COUNT, np.random.default_rng(2))
    others = [axis for axis in range(3) if axis not in scene.axes]
    np.testing.assert_array_equal(episodes.start_m[:, others], episodes.target_m[:, others])


def test_one_dof_starts_above_its_target() -> None:
    episodes = draw_episodes(compiled("panda_1dof"), COUNT, np.random.default_rng(3))
    assert (episodes.start_m[:, 2] > episodes.target_m[:, 2]).all()


def test_candidates_are_drawn_in_equal_shares_and_without_jitter_are_the_points_themselves() -> None:
    scene = compiled("panda_2dof")
    still = scene.params.target.model_copy(update={"jitter_m": (0.0, 0.0, 0.0)})

    fixed = compile_scene("still", scene.params.model_copy(update={"target": still}))
    episodes = draw_episodes(fixed, 16, np.random.default_rng(4))
    points, counts = np.unique(episodes.target_m, axis=0, return_counts=True)
    np.testing.assert_allclose(np.sort(points, axis=0), np.sort(still.candidates_m, axis=0))
    assert counts.tolist() == [4] * 4


def test_same_generator_same_episodes(scene: Scene) -> None:
    first, second = (draw_episodes(scene, 8, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(first.start_m, second.start_m)
    np.testing.assert_array_equal(first.target_m, second.target_m)


def test_a_start_that_cannot_be_is_told() -> None:
    scene = compiled("panda_2dof")
    hidden = scene.params.target.model_copy(update={"seen_pixels": 4000})

    impossible = compile_scene("hidden", scene.params.model_copy(update={"target": hidden}))
    with pytest.raises(BelvedereError, match="no acceptable start for target candidate"):
        draw_episodes(impossible, 1, np.random.default_rng(6))


def test_obstacles_keep_their_clearance() -> None:
    scene = compiled("panda_2dof_obstacle")
    episodes = draw_episodes(scene, COUNT, np.random.default_rng(7))
    for box in scene.params.obstacles:
        for points in (episodes.start_m, episodes.target_m):
            gap = np.abs(points - box.center_m) - box.half_size_m
            assert (gap.max(axis=1) >= scene.params.obstacle_clearance_m).all()


def test_view_of_a_drawn_episode_is_geometry_not_luck() -> None:
    """Sight's count falls to nothing when the camera is turned away from the target."""
    scene = compiled("panda_2dof")
    episodes = draw_episodes(scene, 4, np.random.default_rng(8))
    worlds = Worlds(scene, 4)
    worlds.reset(episodes)
    behind = episodes.target_m + np.array([3.0, 0.0, 0.0])  # behind a camera in front of the robot
    assert Sight(scene, 4).target_pixels(viewpoint(scene.name, 0, 0), worlds.qpos, behind).max() == 0
