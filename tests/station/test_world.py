"""The station's world against the model's, and its gripper against the simulation."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import load_scene
from pipeline.sim.worlds import Worlds
from pipeline.station.world import World

SCENES = ("panda_1dof", "panda_2dof_obstacle", "fetch_reach")


@pytest.mark.parametrize("name", SCENES)
def test_with_a_closed_gripper_it_is_the_model_s_world_bit_for_bit(name: str) -> None:
    scene, rng = load_scene(name), np.random.default_rng(4)
    episode = draw_episodes(scene, 1, rng)
    model, station = Worlds(scene, 1), World(scene)
    model.reset(episode)
    station.reset(episode.start_m[0], episode.target_m[0], opened=False)
    for _ in range(scene.frames):
        action = rng.uniform(-1, 1, scene.action_size)
        model.step(action[None])
        station.step(action)
        assert np.array_equal(model.tip[0], station.tip)
    assert np.array_equal(model.qpos[0], station.qpos.astype(np.float32))


def stood(name: str, above_m: tuple[float, float, float]) -> World:
    """A world whose tip starts so far from the target's centre."""
    scene = load_scene(name)
    world, target = World(scene), np.array([0.5, 0.0, 0.25])
    world.reset(target + above_m, target)
    return world


def rest(world: World, frames: int) -> None:
    for _ in range(frames):
        world.step(np.zeros(world.scene.action_size))


def test_the_panda_s_fingers_open_by_eight_centimetres_and_close() -> None:
    world = stood("panda_2dof", (0, 0, 0))
    gripper = world.gripper
    assert len(gripper.actuators) == 2 and gripper.opened == pytest.approx([0.04, 0.04])
    rest(world, 10)
    assert world.qpos[-2:] == pytest.approx([0.04, 0.04], abs=1e-3)
    world.close()
    rest(world, 15)
    assert world.qpos[-2:] == pytest.approx([0.0, 0.0], abs=1e-3)


def test_closing_does_not_move_the_tip() -> None:
    world = stood("panda_2dof", (0, 0, 0))
    before = world.tip
    world.close()
    rest(world, 15)
    assert world.tip == pytest.approx(before, abs=1e-3)


def test_a_robot_without_finger_actuators_has_no_gripper_and_is_driven_all_the_same() -> None:
    scene = load_scene("fetch_reach")
    world, start = World(scene), np.array(scene.params.start.low_m)
    world.reset(start, start)
    assert not world.gripper.exists and world.touches
    world.close()
    rest(world, 2)


@pytest.mark.parametrize(
    "away, touches",
    [
        ((0.0, 0.0, 0.0), True),
        ((0.0, 0.0, 0.049), True),  # the marker's radius is 0.05
        ((0.0, 0.0, 0.052), False),
        ((0.049, 0.0, 0.0), True),  # across the fingers
        ((0.052, 0.0, 0.0), False),
    ],
)
def test_the_fingers_touch_what_lies_between_them(away: tuple[float, float, float], touches: bool) -> None:
    world = stood("panda_2dof", away)
    assert world.touches is touches


def test_an_open_finger_reaches_a_target_that_the_tip_does_not() -> None:
    world = stood("panda_2dof", (0.0, 0.0, 0.0))
    model, data = world.scene.model, world._data
    pad = data.xaxis[world.gripper.joints[0]]  # the way the finger opens
    beyond = world.tip + 0.08 * pad
    apart = world.gripper.distance_m(model, data, world.scene.tip_site, beyond)
    assert apart == pytest.approx(0.04, abs=1e-6)


def test_open_fingers_touch_no_obstacle_where_episodes_start() -> None:
    """The hand itself may, in the model's episodes too."""
    scene = load_scene("panda_2dof_obstacle")
    world, episodes = World(scene), draw_episodes(scene, 200, np.random.default_rng(6))
    fingers = set(scene.model.jnt_bodyid[world.gripper.joints])
    assert 0.005 < world.gripper.opened.min() < 0.04
    for start_m, target_m in zip(episodes.start_m, episodes.target_m, strict=True):
        world.reset(start_m, target_m)
        contacts = world._data.contact
        touching = {int(scene.model.geom_bodyid[g]) for c in contacts for g in (c.geom1, c.geom2)}
        assert not touching & fingers


@pytest.mark.parametrize("name", ["panda_2dof", "panda_2dof_obstacle"])
def test_the_way_home_ends_at_the_start(name: str) -> None:
    scene, rng = load_scene(name), np.random.default_rng(5)
    for _ in range(3):
        episode = draw_episodes(scene, 1, rng)
        world = World(scene)
        world.reset(episode.start_m[0], episode.target_m[0])
        for action in rng.uniform(-0.4, 0.4, (20, 1)):
            world.step(np.repeat(action, scene.action_size))
        for _ in range(200):
            action_home = world.homeward()
            if action_home is None:
                break
            world.step(action_home)
        assert np.linalg.norm(world.tip - episode.start_m[0]) < 0.006
