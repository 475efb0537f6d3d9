"""What is wrong with a robot's file or declaration is one sentence, which names it and what exists."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.sim.robot_files import digests
from pipeline.sim.robot_params import robot_params
from pipeline.sim.scene import initial_data
from tests.sim import arms
from tests.sim.arms import HOME, MOTORS, SERVOS, mjcf, obj, robot, scene, urdf

GEARED = SERVOS.replace("/>", ' gear="5"/>')
MESH = '<asset><mesh name="part" file="{}"/></asset>'
PART = '<geom type="mesh" mesh="part"/>'
FOUR = ("yaw", "shoulder", "elbow", "wrist")
KEYS = '<keyframe><key name="up"/></keyframe>'
OWN = {"drive": {"actuators": "own"}}
CHECKED = '<asset><texture name="t" type="2d" builtin="checker" width="8" height="8"/>'
CHECKED += '<material name="m" texture="t"/></asset>'
FREE = '<body name="cube"><freejoint/><geom size=".02"/></body>'
HANDLE = '<body name="handle" mocap="true"><geom size=".02"/></body>'
WRONG: dict[str, tuple[str, dict[str, Any], str]] = {
    "tip's site": (
        mjcf(),
        {"tip": {"site": "grab"}},
        r"site for the tip \(of arm.xml\) 'grab' .* available: grip\.",
    ),
    "tip's body": (
        mjcf(FOUR),
        {"tip": {"body": "hand"}},
        "'hand' is unknown; available: base, elbow_link, shoulder",
    ),
    "fixed tip": (mjcf(), {"tip": {"body": "base"}}, "no joint of arm.xml carries the tip, .* body base"),
    "joint": (
        mjcf(),
        {"home": {"yaww": 0.0}},
        "joint below home .* 'yaww' is unknown; available: elbow, roll",
    ),
    "range": (mjcf(), {"home": {"yaw": 3.0}}, r"home.yaw = 3 lies outside the joint's range \[-2.9, 2.9\]"),
    "keyframe": (mjcf(other=KEYS), {"home": "down"}, "keyframe for home .* 'down' is unknown; available: up"),
    "to remove": (
        mjcf(),
        {"remove": ("floor",)},
        "body to remove .* 'floor' is unknown; available: base, elbow",
    ),
    "to hold": (
        mjcf(other=f"<actuator>{MOTORS}</actuator>"),
        {"hold": {"m_yaw": 1.0}},
        "actuator to hold, which moves no joint of the arm, .* 'm_yaw' is unknown; available: none",
    ),
    "motors": (
        mjcf(other=f"<actuator>{MOTORS}</actuator>"),
        OWN,
        "joint yaw of arm.xml has m_yaw, which is no position servo of gear 1, .*drive.actuators: added",
    ),
    "gear": (mjcf(other=f"<actuator>{GEARED}</actuator>"), OWN, "s_yaw, which is no pos"),
    "no actuator": (mjcf(), OWN, "joint yaw of arm.xml has no actuator to follow"),
    "four joints": (
        mjcf(FOUR),
        {},
        r"4 joints of arm.xml carry the tip \(yaw, .*robots.arm.drive.keeps: place",
    ),
    "free cube": (mjcf(world=FREE), {}, r"body cube of arm.xml has a free joint, .*remove: \[cube\]"),
    "mocap": (mjcf(world=HANDLE), {}, "body handle of arm.xml is a mocap body"),
    "mesh": (
        mjcf(hand=PART, other=MESH.format("part.stl")),
        {},
        "mesh part.stl, .* is missing: .*robots has arm.xml",
    ),
    "include": (mjcf(other='<include file="more.xml"/>'), {}, "more.xml, which arm.xml includes, is missing"),
    "texture": (
        mjcf(geom='material="m"', other=CHECKED),
        {},
        "material m of arm.xml covers a geom of body .* texture",
    ),
    "no joint": ("<mujoco><worldbody><body name='b'/></worldbody></mujoco>", {}, "arm.xml holds no joint"),
    "no XML": ("hello", {}, "arm.xml is no XML"),
    "no MJCF": (
        "<mujoco><worldbody><geom colour='1'/></worldbody></mujoco>",
        {},
        "MuJoCo cannot read .*colour",
    ),
    "does not compile": (mjcf(hand=PART), {}, "MuJoCo cannot read .*part"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_file_that_does_not_fit_its_declaration_is_told(wrong: str, tmp_path: Path) -> None:
    text, declared, told = WRONG[wrong]
    with pytest.raises(BelvedereError, match=told) as error:
        scene(tmp_path, robot(tmp_path, text, **declared))
    assert str(error.value).startswith("robot arm: ")
    assert "\n" not in str(error.value) and str(error.value).endswith(".")


@pytest.mark.parametrize(
    ("file", "told"),
    [
        ("robots/other.xml", "robots/other.xml is missing: there is no .*; .*robots has arm.xml"),
        ("robots/deep/er/other.xml", "is missing: .*robots has arm.xml"),
        ("arm.xml", "arm.xml does not lie in the repository's folder robots/"),
        ("robots/../../arm.xml", "does not lie in the repository's folder"),
        ("/robots/arm.xml", "does not lie in the repository's folder"),
        ("no_such_package:arm.xml", "no Python package 'no_such_package' .* pip install no-such-package"),
        ("dm_control:../arm.xml", "is no path inside the Python package dm_control"),
        ("dm_control:third_party/kinova/jaco.xml", "kinova has .*jaco_arm.xml"),
        ("dm_control:third_party/kinova/meshes_decimated/base.stl", r"neither MJCF \(.xml\) nor URDF"),
    ],
)
def test_where_a_file_may_lie(file: str, told: str, tmp_path: Path) -> None:
    robot(tmp_path, mjcf())
    with pytest.raises(BelvedereError, match=told):
        scene(tmp_path, robot(tmp_path, file=file, tip={"site": "grip"}))


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (urdf(mesh="part.dae"), "arm.urdf names the mesh part.dae, which MuJoCo does not read; it takes STL"),
        (urdf(mesh="part.stl"), "mesh part.stl, which arm.urdf names, is missing"),
        (urdf(mesh="package://my_arm/part.stl"), "none of the folders above arm.urdf holds my_arm/part.stl"),
        (
            urdf(root="xmlns:xacro='x'", more="<xacro:include filename='a'/>"),
            "arm.urdf is a xacro, .* expand it",
        ),
    ],
)
def test_urdfs_that_would_lose_something_are_told(text: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match=told):
        scene(tmp_path, robot(tmp_path, text, "urdf", tip={"body": "tool0"}))


@pytest.mark.parametrize("word", ["o", "g"])
def test_obj_files_keep_all_their_objects(word: str, tmp_path: Path) -> None:
    """MuJoCo alone keeps one of the three."""
    (tmp_path / "robots/meshes").mkdir(parents=True)
    (tmp_path / "robots/meshes/part.obj").write_text(obj(3, word))
    text = mjcf(hand=PART, other=MESH.format("part.obj")).replace("<compiler", '<compiler meshdir="meshes"')
    arm = scene(tmp_path, robot(tmp_path, text, home=HOME))
    assert arm.model.nmeshface == 36


def test_a_urdf_keeps_visuals_and_fixed_links_and_finds_its_packages(tmp_path: Path) -> None:
    """As a ROS workspace has it: the URDF in one package, meshes in another; and an undeclared prefix."""
    (tmp_path / "robots/my_arm/meshes").mkdir(parents=True)
    (tmp_path / "robots/my_arm/meshes/part.obj").write_text(obj(2))
    text = urdf(mesh="package://my_arm/meshes/part.obj").replace(
        'velocity="1"', 'velocity="1" drake:acceleration="1"'
    )
    declared = robot(tmp_path, text, "urdf", tip={"body": "tool0"}, home=HOME)
    arm = scene(tmp_path, declared)
    assert arm.model.nmeshface == 24
    assert arm.model.body("robot/tool0").id
    assert {path.name for path in arm.robot.files} == {"arm.urdf", "part.obj"}
    assert np.isfinite(initial_data(arm).qpos).all()


def test_every_file_that_is_read_decides_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "robots/meshes").mkdir(parents=True)
    part = tmp_path / "robots/meshes/part.obj"
    part.write_text(obj(1))
    included = tmp_path / "robots/more.xml"
    included.write_text(f"<mujocoinclude>{MESH.format('part.obj')}</mujocoinclude>")
    text = mjcf(hand=PART, other='<include file="more.xml"/>').replace(
        "<compiler", '<compiler meshdir="meshes"'
    )
    declared = robot(tmp_path, text, home=HOME)
    first = scene(tmp_path, declared)
    assert set(digests(first.robot.files)) == {"arm.xml", "more.xml", "meshes/part.obj"}
    assert digests([part]) == {"part.obj": hashlib.sha256(part.read_bytes()).hexdigest()}
    (tmp_path / "robots/README.md").write_text("nothing")
    assert scene(tmp_path, declared).cache_key == first.cache_key
    for changed in (part, included):
        before = scene(tmp_path, declared).cache_key
        changed.write_text(changed.read_text().replace("0.03", "0.04") + "\n")
        assert scene(tmp_path, declared).cache_key != before
    assert (
        scene(tmp_path, robot(tmp_path, **declared.model_dump() | {"home": {}})).cache_key != first.cache_key
    )


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"tip": {}}, "robots.arm.tip is not valid: tip names a site or a body"),
        (
            {"tip": {"site": "a", "body": "b"}},
            "tip names a site or a body of the robot's file, one of the two",
        ),
        ({"tip": None}, "robots.arm.tip = None is not valid"),
        ({"home": [1, 2]}, "robots.arm.home is not valid: it maps joints to positions"),
        ({"home": {"yaw": "1"}}, "robots.arm.home is not valid: it maps joints to positions"),
        ({"drive": {"keeps": "posture"}}, "drive.keeps = 'posture' is not valid: .*'pose' or 'place'"),
        (
            {"drive": {"actuators": "own", "frequency_hz": 9}},
            "frequency_hz would change nothing with actuators: own; only added servos are tuned",
        ),
        ({"drive": {"actuators": "weld"}}, "weld is not for build: attached, which takes added or own"),
        (
            {"build": "kitchen_panda", "drive": {"actuators": "own"}, "remove": ["a"]},
            "not for build: kitchen_panda",
        ),
        ({"colour": "red"}, "robots.arm.colour = 'red' is not valid"),
    ],
)
def test_declarations_that_are_not_valid_are_told(changes: dict[str, Any], told: str, tmp_path: Path) -> None:
    path = tmp_path / "params.yaml"
    path.write_text(
        json.dumps({"robots": {"arm": {"file": "robots/a.xml", "tip": {"site": "t"}, **changes}}})
    )
    params._tree.cache_clear()
    with pytest.raises(BelvedereError, match=told):
        robot_params("arm", path)


def test_the_shortest_declaration_is_file_and_tip(tmp_path: Path) -> None:
    arm = scene(tmp_path, robot(tmp_path, **{key: arms.JACO[key] for key in ("file", "tip")}))
    assert len(arm.robot.arm) == 6


@pytest.mark.parametrize(
    ("build", "actuators", "told"),
    [
        ("kitchen_panda", "own", "assets.xml, which belongs to robots/arm.xml, is missing"),
        ("fetch_reach", "weld", "mocap body .* unknown"),
    ],
)
def test_files_that_a_builder_does_not_know_are_told(
    build: str, actuators: str, told: str, tmp_path: Path
) -> None:
    with pytest.raises(BelvedereError, match=told):
        scene(tmp_path, robot(tmp_path, mjcf(), build=build, drive={"actuators": actuators}))
