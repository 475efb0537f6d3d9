"""Episodes: what is drawn lies where it may, varies enough, and never depends on a viewpoint."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from pipeline.contract.errors import BelvedereError
from pipeline.sim.draws import draw_episodes, start_density
from pipeline.sim.scene import Scene
from tests.sim.conftest import compile_changed, compiled

COUNT = 64


def test_draws_spread_over_the_workspace(scene: Scene) -> None:
    episodes = draw_episodes(scene, 256, np.random.default_rng(1))
    axes = list(scene.axes)
    workspace = (np.array(scene.params.workspace.high_m) - scene.params.workspace.low_m)[axes]
    assert (np.ptp(episodes.target_m[:, axes], axis=0) >= workspace / 3).all()
    if scene.robot.control == "joints":  # Fetch always starts at the same place
        assert (np.ptp(episodes.start_m[:, axes], axis=0) >= 0.6 * workspace).all()


def test_the_way_is_along_the_controlled_axes_alone(scene: Scene) -> None:
    episodes = draw_episodes(scene, COUNT, np.random.default_rng(2))
    others = [axis for axis in range(3) if axis not in scene.axes]
    np.testing.assert_array_equal(episodes.start_m[:, others], episodes.target_m[:, others])


def test_one_dof_starts_above_its_target() -> None:
    episodes = draw_episodes(compiled("panda_1dof"), COUNT, np.random.default_rng(3))
    assert (episodes.start_m[:, 2] > episodes.target_m[:, 2]).all()


def jittered(name: str, *jitter_m: float) -> Scene:
    """A scene of params.yaml with another jitter."""
    params = compiled(name).params
    target = params.target.model_copy(update={"jitter_m": jitter_m})
    return compile_changed(name, params.model_copy(update={"target": target}))


def test_the_candidates_are_drawn_in_equal_shares(scene: Scene) -> None:
    candidates = np.array(scene.params.target.candidates_m)
    episodes = draw_episodes(scene, 4 * len(candidates), np.random.default_rng(4))
    off = np.abs(episodes.target_m[:, None] - candidates)
    assert (off.min(axis=1) <= scene.params.target.jitter_m).all()
    assert np.bincount(off.sum(axis=2).argmin(axis=1)).tolist() == [4] * len(candidates)


def test_jitter_moves_targets_uniformly_on_the_controlled_axes_only() -> None:
    scene = jittered("panda_2dof", 0.02, 0.03, 0.05)
    targets = draw_episodes(scene, 4000, np.random.default_rng(4)).target_m
    candidates = np.array(scene.params.target.candidates_m)
    moved = targets - candidates[np.linalg.norm(targets[:, None] - candidates, axis=2).argmin(axis=1)]
    assert not moved[:, 0].any()
    for axis, most in ((1, 0.03), (2, 0.05)):
        assert stats.kstest(moved[:, axis], stats.uniform(-most, 2 * most).cdf).pvalue > 0.001


@pytest.mark.parametrize("jitter_m", [0.0, 0.05])
def test_start_density_is_that_of_the_draws(jitter_m: float) -> None:
    """Of episodes that start near a height, the targets' shares are those that the density gives (Bayes)."""
    scene = jittered("panda_1dof", 0.0, 0.0, jitter_m)
    drawn, near_m = draw_episodes(scene, 200_000, np.random.default_rng(9)), 0.004
    targets = draw_episodes(scene, 4000, np.random.default_rng(10)).target_m
    for height_m in (0.17, 0.26, 0.35, 0.46):
        found = drawn.target_m[np.abs(drawn.start_m[:, 2] - height_m) < near_m, 2]
        weights = start_density(scene, np.array([[0.5, 0.0, height_m]]), targets)[0]
        for limit_m in (0.15, 0.25, 0.35):
            share = weights[targets[:, 2] < limit_m].sum() / weights.sum()
            assert (found < limit_m).mean() == pytest.approx(share, abs=0.03)


def test_a_start_tells_of_its_target_what_the_axes_without_control_share() -> None:
    scene = compiled("panda_1dof")
    start, targets = np.array([[0.5, 0.0, 0.4]]), np.array([[0.5, 0.0, 0.2], [0.5, 0.1, 0.2]])
    assert (start_density(scene, start, targets) > 0).tolist() == [[True, False]]


def test_same_generator_same_episodes(scene: Scene) -> None:
    first, second = (draw_episodes(scene, 8, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(first.start_m, second.start_m)
    np.testing.assert_array_equal(first.target_m, second.target_m)


def test_a_start_that_cannot_be_is_told() -> None:
    params = compiled("panda_2dof_obstacle").params
    impossible = compile_changed("filled", params.model_copy(update={"obstacle_clearance_m": 0.5}))
    with pytest.raises(BelvedereError, match="no acceptable start for target candidate"):
        draw_episodes(impossible, 1, np.random.default_rng(6))


def test_obstacles_keep_their_clearance() -> None:
    scene = compiled("panda_2dof_obstacle")
    episodes = draw_episodes(scene, COUNT, np.random.default_rng(7))
    for box in scene.params.obstacles:
        for points in (episodes.start_m, episodes.target_m):
            gap = np.abs(points - box.center_m) - box.half_size_m
            assert (gap.max(axis=1) >= scene.params.obstacle_clearance_m).all()
