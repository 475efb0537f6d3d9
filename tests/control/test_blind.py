"""The target-blind anchor: as good as can be without the target, and no better than that."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
from scipy import optimize

from pipeline.contract import params
from pipeline.control.anchors import believing, expert, nothing, play
from pipeline.control.blind import TargetBlind, geometric_median
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds

SCENES = tuple(params.value("scenes"))


def test_it_is_never_told_a_target() -> None:
    assert list(inspect.signature(TargetBlind.policy).parameters) == ["self", "start_m"]
    assert list(inspect.signature(TargetBlind.targets).parameters) == ["self", "start_m"]
    assert list(inspect.signature(TargetBlind).parameters) == ["scene", "rng"]


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_the_geometric_median_is_the_place_of_least_mean_distance(dimensions: int) -> None:
    rng = np.random.default_rng(dimensions)
    points, weights = rng.normal(size=(9, dimensions)), rng.uniform(size=(5, 9))
    for found, weight in zip(geometric_median(points, weights), weights, strict=True):

        def cost(place: np.ndarray, weight: np.ndarray = weight) -> float:
            return float(weight @ np.linalg.norm(points - place, axis=1))

        options = {"xatol": 1e-9, "fatol": 1e-12, "maxiter": 10_000}
        best = min(optimize.minimize(cost, p, method="Nelder-Mead", options=options).fun for p in points)
        assert cost(found) <= best + 1e-4


def test_in_one_axis_it_is_the_weighted_median() -> None:
    points = np.array([[0.1], [0.2], [0.3], [0.4]])
    weights = np.array([[1.0, 1.0, 1.0, 4.0], [1.0, 3.0, 1.0, 0.0], [0.0, 0.0, 2.0, 1.0]])
    np.testing.assert_allclose(geometric_median(points, weights), [[0.4], [0.2], [0.3]], atol=1e-4)


def test_in_one_axis_no_constant_height_leaves_targets_nearer_on_average() -> None:
    """Brute force: of many drawn episodes those that start near a height, and every height to go to."""
    scene, rng = load_scene("panda_1dof"), np.random.default_rng(2)
    target_blind, drawn = TargetBlind(scene, np.random.default_rng(1)), draw_episodes(scene, 100_000, rng)
    heights = np.linspace(scene.params.workspace.low_m[2], scene.params.workspace.high_m[2], 91)
    for start in (0.15, 0.23, 0.28, 0.35, 0.39, 0.44, 0.47):
        targets = drawn.target_m[np.abs(drawn.start_m[:, 2] - start) < 0.004, 2]
        believed = target_blind.targets(np.array([[0.5, 0.0, start]]))[0]
        goal = believed[0]
        assert (believed == goal).all()
        assert goal[:2].tolist() == [0.5, 0.0]
        best = np.abs(targets - heights[:, None]).mean(axis=1).min()
        assert np.abs(targets - goal[2]).mean() <= best + 0.002


def test_in_one_axis_no_constant_goal_earns_more() -> None:
    scene, count = load_scene("panda_1dof"), 32
    worlds, episodes = Worlds(scene, count), draw_episodes(scene, count, np.random.default_rng(3))

    def earned(goal_m: np.ndarray) -> float:
        return float(play(worlds, episodes, believing(scene, goal_m)).reward.sum(axis=1).mean())

    ours = TargetBlind(scene, np.random.default_rng(1)).targets(episodes.start_m)
    goals = [np.where([0, 0, 1], height, ours) for height in np.linspace(0.06, 0.46, 6)]
    assert earned(ours) >= max(earned(goal) for goal in goals)


@pytest.mark.parametrize("name", SCENES)
def test_sight_is_needed(name: str) -> None:
    """Half of what can be earned, or more, is for those who see; to know the tip alone is worth something."""
    scene = load_scene(name)
    count = 256 if len(scene.axes) == 1 else 48  # where starts tell most of targets, the share is .53
    worlds = Worlds(scene, count, threads=2)
    episodes = draw_episodes(scene, count, np.random.default_rng(4))
    blind = TargetBlind(scene, np.random.default_rng(1)).policy(episodes.start_m)
    policies = {"no_op": nothing, "blind": blind, "expert": expert(scene)}
    mean = {key: play(worlds, episodes, p).reward.sum(axis=1).mean() for key, p in policies.items()}
    assert mean["expert"] - mean["blind"] >= 0.5 * (mean["expert"] - mean["no_op"])
    # Fetch starts in the middle of its targets, where there is nowhere better to go
    least = -0.02 if name == "fetch_reach" else 0.3
    assert mean["blind"] >= mean["no_op"] + least


def test_a_goal_is_kept_whatever_the_target() -> None:
    """Other targets behind the same starts: the tips go the same ways to the bit."""
    scene = load_scene("panda_2dof_obstacle")
    worlds, episodes = Worlds(scene, 8), draw_episodes(scene, 8, np.random.default_rng(5))
    goals = TargetBlind(scene, np.random.default_rng(1)).targets(episodes.start_m)
    others = Episodes.at(episodes.start_m, episodes.target_m[::-1].copy())
    tips = [play(worlds, drawn, believing(scene, goals)).tip_m for drawn in (episodes, others)]
    np.testing.assert_array_equal(*tips)
    assert np.linalg.norm(tips[0][:, -1] - goals[:, -1], axis=1).max() < 0.02
