"""Foreign arms: what a file holds becomes a scene in which the arm reaches, stands, touches and is seen."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import Renderer
from pipeline.sim.arm_controllers import JointController, TipPose
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.expert import Expert
from pipeline.sim.params import Box
from pipeline.sim.robot import HIDDEN_GROUP, arm_actuators
from pipeline.sim.scene import CAMERA, Scene, initial_data
from pipeline.sim.tasks.bodies import TARGET, TARGET_GROUP
from pipeline.sim.worlds import Worlds
from tests.sim import arms
from tests.sim.arms import HOME, MOTORS, SERVOS, mjcf, robot, scene, urdf

COUNT = 8
FIVE = ("yaw", "shoulder", "elbow", "wrist", "turn")
POSED = {"home": HOME}
FREE = {"home": {name: HOME[name] for name in FIVE}, "drive": {"keeps": "place"}}
CASES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "no actuators": (mjcf(), "xml", POSED),
    "motors": (mjcf(other=f"<actuator>{MOTORS}</actuator>"), "xml", POSED),
    "its own servos": (
        mjcf(other=f"<actuator>{SERVOS}</actuator>"),
        "xml",
        {**POSED, "drive": {"actuators": "own"}},
    ),
    "unlimited joints": (mjcf(joint=""), "xml", POSED),
    "five joints": (mjcf(FIVE), "xml", FREE),
    "a tip by body and offset": (
        mjcf(),
        "xml",
        {**POSED, "tip": {"body": "turn_link", "offset_m": (0, 0, 0.06)}},
    ),
    "much friction": (mjcf(joint='damping="30" frictionloss="9" stiffness="9"'), "xml", POSED),
    "URDF": (urdf(), "urdf", {**POSED, "tip": {"body": "tool0"}}),
    "URDF of five joints": (urdf(FIVE), "urdf", {**FREE, "tip": {"body": "tool0"}}),
    "Jaco": ("", "", {**arms.JACO, "home": arms.JACO_HOME}),
}


@pytest.fixture(params=CASES)
def arm(request: pytest.FixtureRequest, tmp_path: Path) -> Scene:
    text, suffix, declared = CASES[request.param]
    return scene(tmp_path, robot(tmp_path, text, suffix, **declared))


def test_the_expert_reaches_every_target(arm: Scene) -> None:
    worlds, expert = Worlds(arm, COUNT), Expert(arm)
    worlds.reset(draw_episodes(arm, COUNT, np.random.default_rng(1)))
    for _ in range(arm.frames):
        worlds.step(expert(worlds.state))
    assert np.linalg.norm(worlds.tip - worlds.target, axis=1).max() < 2e-3


def test_an_arm_that_is_asked_for_nothing_stands_still(arm: Scene) -> None:
    worlds, episodes = Worlds(arm, COUNT), draw_episodes(arm, COUNT, np.random.default_rng(2))
    worlds.reset(episodes)
    for _ in range(arm.frames):
        worlds.step(np.zeros((COUNT, 2)))
    assert np.abs(worlds.tip - episodes.start_m).max() < 2e-3


def test_a_full_push_moves_it_as_far_as_the_panda(arm: Scene) -> None:
    if arm.declared.drive.actuators == "own":
        return
    worlds = Worlds(arm, COUNT)
    worlds.reset(draw_episodes(arm, COUNT, np.random.default_rng(3)))
    for _ in range(4):
        before = worlds.tip
        worlds.step(np.stack([np.zeros(COUNT), np.sign(0.35 - before[:, 2])], axis=1))
    assert 0.01 < np.abs(worlds.tip - before)[:, 2].max() < 0.03


def test_without_compensation_it_sinks(tmp_path: Path) -> None:
    weak = {"frequency_hz": 2}
    sunk = []
    for gravity in ("compensated", "acts"):
        arm = scene(tmp_path, robot(tmp_path, mjcf(), home=HOME, gravity=gravity, drive=weak))
        worlds, episodes = Worlds(arm, 1), draw_episodes(arm, 1, np.random.default_rng(2))
        worlds.reset(episodes)
        for _ in range(arm.frames):
            worlds.step(np.zeros((1, 2)))
        sunk.append(float((episodes.start_m - worlds.tip)[0, 2]))
    assert abs(sunk[0]) < 2e-3 < 0.02 < sunk[1]


def test_what_stands_in_its_way_stops_it(tmp_path: Path) -> None:
    wall = Box(center_m=(0.45, 0.0, 0.25), half_size_m=(0.1, 0.01, 0.25))
    passed = []
    for obstacles in ((), (wall,)):
        arm = scene(tmp_path, robot(tmp_path, mjcf(), home=HOME), obstacles)
        start = np.array([[0.45, -0.1, 0.3]])
        worlds = Worlds(arm, 1)
        worlds.reset(Episodes.at(start, start * [1, -1, 1]))
        for _ in range(arm.frames):
            worlds.step(np.array([[1.0, 0.0]]))
        passed.append(float(worlds.tip[0, 1]))
    assert passed[0] > 0.1 and passed[1] < 0.0


def test_a_singular_wrist_throws_no_joint(tmp_path: Path) -> None:
    """With the wrist nearly straight, keeping the pose takes turns of the two joints about the same line."""
    turned = {}
    for limit in (0.4, 100.0):
        near = {**HOME, "wrist": 0.003}
        arm = scene(tmp_path, robot(tmp_path, mjcf(joint=""), home=near, drive={"largest_step": limit}))
        start = initial_data(arm).site_xpos[arm.tip_site][None].copy()
        ik = JointController(arm, 1, 1)
        ik.solve(start)
        before = ik.move(TipPose(start, start, np.zeros((1, 4))), start)["ctrl"].copy()
        after = ik.move(TipPose(start, start, np.zeros((1, 4))), start + np.array([0.0, 0.05, 0.0]))["ctrl"]
        turned[limit] = float(np.abs(after - before).max())
    assert turned[0.4] <= 0.4 + 1e-9 < 2.0 < turned[100.0]


def test_names_of_the_file_clash_with_none_of_the_scenes(tmp_path: Path) -> None:
    hand = "".join(
        f'<body name="{name}"><geom name="{name}" size="0.01"/></body>' for name in (TARGET, "desk")
    )
    hand += '<site name="tip"/><camera name="viewpoint"/><geom name="obstacle0" size="0.01"/>'
    box = Box(center_m=(0.0, 0.8, 0.1), half_size_m=(0.1, 0.1, 0.1))
    arm = scene(tmp_path, robot(tmp_path, mjcf(hand=hand, world='<light name="above"/>'), home=HOME), (box,))
    assert arm.model.body(TARGET).mocapid[0] == 0
    assert [arm.model.camera(c).name for c in range(arm.model.ncam)] == [CAMERA]


def test_light_floor_sky_sensors_and_options_of_the_file_are_left_out(tmp_path: Path) -> None:
    world = '<light name="spot" type="spot" pos="0 0 2"/><geom name="floor" type="plane" size="1 1 .1"/>'
    world += '<camera name="own"/>'
    other = '<option integrator="RK4" timestep="0.01" gravity="0 0 0"><flag contact="disable"/></option>'
    other += '<visual><headlight ambient="1 1 1"/></visual><sensor><jointpos joint="yaw"/></sensor>'
    other += (
        '<asset><texture name="sky" type="skybox" builtin="flat" width="8" height="8" rgb1="1 0 0"/></asset>'
    )
    arm = scene(tmp_path, robot(tmp_path, mjcf(world=world, other=other), home=HOME))
    plain = scene(tmp_path, robot(tmp_path, mjcf(), home=HOME))
    for count in ("nlight", "ncam", "ngeom", "nsensor", "ntex", "nkey"):
        assert getattr(arm.model, count) == getattr(plain.model, count), count
    assert arm.model.opt.integrator == mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    assert arm.model.opt.gravity[2] == pytest.approx(-9.81) and arm.model.opt.timestep == 0.002
    assert not arm.model.opt.disableflags
    assert arm.robot.dropped == ("light spot", "camera own", "world geom floor")
    view = Viewpoint(scene="any", theta=30, phi=20)
    state = initial_data(arm).qpos[None].astype(np.float32), np.array([[0.45, 0.0, 0.3]])
    first, second = (Renderer(each, view, 1).render(*state).copy() for each in (arm, plain))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("group", [0, 1, 2])
def test_visuals_are_drawn_in_any_group_and_never_in_the_targets(tmp_path: Path, group: int) -> None:
    text = mjcf(
        geom='group="3" rgba="0 1 0 1"',
        hand=f'<geom name="seen" size=".02" group="{group}" contype="0" conaffinity="0"/>',
    )
    arm = scene(tmp_path, robot(tmp_path, text, home=HOME))
    groups = arm.model.geom_group
    assert np.flatnonzero(groups == TARGET_GROUP).tolist() == list(arm.target_geoms)
    assert groups[arm.model.geom("robot/seen").id] == 0
    hand = arm.model.body("robot/turn_link")
    beside = [g for g in range(arm.model.ngeom) if arm.model.geom_bodyid[g] == hand.id]
    assert sorted(groups[beside]) == [0, HIDDEN_GROUP]  # the colliding one is hidden where a visual one is
    assert (
        groups[arm.model.geom_bodyid == arm.model.body("robot/base").id] == 0
    ).all()  # and drawn where not


def test_a_gripper_is_held(tmp_path: Path) -> None:
    """Two fingers that a tendon's actuator closes, coupled by an equality: it is no joint of the arm."""
    finger = '<body name="{0}" pos="0 {1} .05"><geom size=".01" mass=".05"/>'
    finger += '<joint name="{0}" type="slide" axis="0 {2} 0" range="0 .04" damping="5"/></body>'
    hand = finger.format("left", 0.05, -1) + finger.format("right", -0.05, 1)
    other = '<equality><joint joint1="left" joint2="right"/></equality><tendon><fixed name="both">'
    other += '<joint joint="left" coef=".5"/><joint joint="right" coef=".5"/></fixed></tendon><actuator>'
    other += '<position name="grip" tendon="both" kp="500" kv="20"/></actuator>'
    arm = scene(tmp_path, robot(tmp_path, mjcf(hand=hand, other=other), home=HOME, hold={"grip": 0.03}))
    assert arm.robot.arm == tuple(f"robot/{name}" for name in HOME)
    worlds, rng = Worlds(arm, 4), np.random.default_rng(0)
    worlds.reset(draw_episodes(arm, 4, rng))
    for _ in range(arm.frames):
        worlds.step(rng.uniform(-1, 1, (4, 2)))
    fingers = [arm.model.joint(f"robot/{name}").qposadr[0] for name in ("left", "right")]
    np.testing.assert_allclose(worlds.qpos[:, fingers], 0.03, atol=2e-3)


def test_loose_fingers_of_a_urdf_are_held_at_home(tmp_path: Path) -> None:
    more = f'<link name="finger">{arms.INERTIAL}</link><joint name="finger_joint" type="prismatic">'
    more += '<parent link="turn_link"/><child link="finger"/><axis xyz="0 0 1"/>'
    more += '<limit lower="0" upper=".04" effort="1" velocity="1"/></joint>'
    declared = robot(
        tmp_path, urdf(more=more), "urdf", tip={"body": "tool0"}, home={**HOME, "finger_joint": 0.02}
    )
    arm = scene(tmp_path, declared)
    assert len(arm_actuators(arm.model, arm.robot)) == 6 < arm.model.nu
    worlds = Worlds(arm, 1)
    worlds.reset(draw_episodes(arm, 1, np.random.default_rng(0)))
    for _ in range(arm.frames):
        worlds.step(np.ones((1, 2)))
    finger = arm.model.joint("robot/finger_joint").qposadr[0]
    assert worlds.qpos[0, finger] == pytest.approx(0.02, abs=1e-3)


def test_home_is_a_keyframe_with_its_controls_or_the_middle_of_a_range_without_0(tmp_path: Path) -> None:
    keys = f'<keyframe><key name="up" qpos="{" ".join(map(str, HOME.values()))}"/></keyframe>'
    arm = scene(tmp_path, robot(tmp_path, mjcf(other=keys), home="up"))
    assert arm.robot.home == pytest.approx({f"robot/{name}": value for name, value in HOME.items()})
    arm = scene(tmp_path, robot(tmp_path, mjcf(joint='range="0.4 1.4"')))
    np.testing.assert_allclose(list(arm.robot.home.values()), 0.9)


def test_the_base_is_placed_and_turned(tmp_path: Path) -> None:
    here = scene(tmp_path, robot(tmp_path, mjcf(), home=HOME))
    base = {"position_m": (0.1, 0.2, 0.3), "turn_deg": 90}
    there = scene(tmp_path, robot(tmp_path, mjcf(), home=HOME, base=base))
    x, y, z = initial_data(here).site_xpos[here.tip_site]
    np.testing.assert_allclose(
        initial_data(there).site_xpos[there.tip_site], [0.1 - y, 0.2 + x, 0.3 + z], atol=1e-9
    )


def test_what_is_removed_takes_all_that_hangs_on_it_along(tmp_path: Path) -> None:
    """A mocap handle that a weld pulls the hand to, and a table with a drawer."""
    world = '<body name="handle" mocap="true"><geom size=".02"/></body><body name="table"><geom size=".1"/>'
    world += '<joint name="drawer" type="slide"/></body>'
    other = '<equality><weld body1="handle" body2="turn_link"/></equality>'
    other += '<actuator><motor joint="drawer"/></actuator>'
    text = mjcf(world=world, other=other)
    arm = scene(tmp_path, robot(tmp_path, text, home=HOME, remove=("handle", "table")))
    assert (arm.model.neq, arm.model.nu, arm.model.nmocap) == (0, 6, 1)
