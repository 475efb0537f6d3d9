"""Small arms written by hand, as MJCF and URDF, and scenes with them."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

from pipeline.sim.params import Box, SceneParams
from pipeline.sim.robot_params import RobotParams
from pipeline.sim.scene import Scene, compile_scene
from tests.sim.conftest import compiled

HOME = {"yaw": 0.0, "shoulder": 0.5, "elbow": 1.3, "roll": 0.0, "wrist": 1.3, "turn": 0.0}
AXES = {
    "yaw": "0 0 1",
    "shoulder": "0 1 0",
    "elbow": "0 1 0",
    "roll": "0 0 1",
    "wrist": "0 1 0",
    "turn": "0 0 1",
}
LENGTHS = {"yaw": 0.2, "shoulder": 0.35, "elbow": 0.2, "roll": 0.15, "wrist": 0.06, "turn": 0.06}
INERTIA = '<inertia ixx=".01" iyy=".01" izz=".01" ixy="0" ixz="0" iyz="0"/>'
INERTIAL = f'<inertial><mass value="1"/>{INERTIA}</inertial>'
MOTORS = "".join(f'<motor name="m_{joint}" joint="{joint}"/>' for joint in AXES)
SERVOS = "".join(f'<position name="s_{joint}" joint="{joint}" kp="200" kv="20"/>' for joint in AXES)
JACO = {
    "file": "dm_control:third_party/kinova/jaco_arm.xml",
    "tip": {"site": "wristsite"},
    "base": {"position_m": (0.1, 0.0, -0.27)},
}
JACO_HOME = {
    "joint_1": 0.3,
    "joint_2": 1.9,
    "joint_3": 1.85,
    "joint_4": -0.6,
    "joint_5": -1.3,
    "joint_6": -0.4,
}


def mjcf(
    joints: tuple[str, ...] = tuple(AXES),
    *,
    geom: str = "",
    joint: str = 'range="-2.9 2.9"',
    hand: str = "",
    world: str = "",
    other: str = "",
) -> str:
    """An arm of capsules, a chain of ``joints``, with a site ``grip`` at its end.

    Args:
        joints: those of :data:`AXES` that it has.
        geom: attributes of its geoms.
        joint: attributes of its joints.
        hand: elements of its last link.
        world: elements beside it in the world.
        other: elements of the file.
    """
    inner, below = f'<site name="grip" pos="0 0 {LENGTHS[joints[-1]]}"/>{hand}', ""
    for at in range(len(joints) - 1, -1, -1):
        name = joints[at]
        below = f"0 0 {LENGTHS[joints[at - 1]]}" if at else "0 0 0.1"
        inner = (
            f'<body name="{name}_link" pos="{below}"><joint name="{name}" axis="{AXES[name]}" {joint}/>'
            f'<geom type="capsule" size="0.03" fromto="0 0 0 0 0 {LENGTHS[name]}" {geom}/>{inner}</body>'
        )
    base = f'<body name="base"><geom type="box" size="0.06 0.06 0.05" pos="0 0 0.05" {geom}/>{inner}</body>'
    return (
        f'<mujoco model="arm"><compiler angle="radian"/>{other}<worldbody>{world}{base}</worldbody></mujoco>'
    )


def urdf(joints: tuple[str, ...] = tuple(AXES), *, mesh: str = "", root: str = "", more: str = "") -> str:
    """The same arm as URDF, with a fixed link ``tool0`` at its end.

    Args:
        joints: those of :data:`AXES` that it has.
        mesh: the first link's visual, instead of a cylinder.
        root: attributes of the element ``robot``.
        more: links and joints besides.
    """
    shape = '<cylinder radius="0.03" length="0.1"/>'
    links, parent, length = f'<link name="base_link">{INERTIAL}</link>', "base_link", 0.1
    for place, name in enumerate(joints):
        visual = f'<mesh filename="{mesh}"/>' if mesh and not place else shape
        links += (
            f'<link name="{name}_link">{INERTIAL}<visual><geometry>{visual}</geometry></visual>'
            f"<collision><geometry>{shape}</geometry></collision></link>"
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>'
            f'<origin xyz="0 0 {length}"/><axis xyz="{AXES[name]}"/>'
            '<limit lower="-2.9" upper="2.9" effort="0" velocity="1"/>'
            '<dynamics damping="9" friction="9"/></joint>'
        )
        parent, length = f"{name}_link", LENGTHS[name]
    links += (
        f'<link name="tool0"/><joint name="tool0_fixed" type="fixed"><parent link="{parent}"/>'
        f'<child link="tool0"/><origin xyz="0 0 {length}"/></joint>'
    )
    return f'<robot name="arm" {root}>{links}{more}</robot>'


def obj(parts: int, word: str = "o") -> str:
    """An OBJ file of cubes beside each other, of 12 faces each, every one an object of its own."""
    text, faces = "", ((1, 2, 4), (1, 4, 3), (5, 8, 6), (5, 7, 8), (1, 5, 6), (1, 6, 2))
    faces += ((3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5), (2, 6, 8), (2, 8, 4))
    for part in range(parts):
        corners = itertools.product((0.0, 0.03), repeat=3)
        text += "".join(f"v {x + 0.05 * part} {y} {z}\n" for x, y, z in corners) + f"{word} part{part}\n"
        text += "".join("f " + " ".join(str(corner + 8 * part) for corner in face) + "\n" for face in faces)
    return text


def robot(root: Path, text: str = "", suffix: str = "xml", **declared: Any) -> RobotParams:
    """Writes a file to ``robots/`` below a root, and declares it."""
    if text:
        (root / "robots").mkdir(exist_ok=True)
        (root / f"robots/arm.{suffix}").write_text(text)
        declared = {"file": f"robots/arm.{suffix}", "tip": {"site": "grip"}} | declared
    return RobotParams(**declared)


def scene(root: Path, declared: RobotParams, obstacles: tuple[Box, ...] = (), name: str = "arm") -> Scene:
    """Reaching on y and z about (0.45, 0, 0.35) m, without a desk."""
    low, high = (0.45, -0.12, 0.25), (0.45, 0.12, 0.45)
    given = compiled("panda_2dof").params
    ends = {"low_m": low, "high_m": high}
    target = given.target.model_copy(update={"candidates_m": (low, high), "jitter_m": (0.0, 0.0, 0.0)})
    changes: dict[str, Any] = {"robot": name, "desk": None, "obstacles": obstacles, "target": target}
    changes |= {
        "workspace": given.workspace.model_copy(update=ends),
        "start": given.start.model_copy(update=ends),
    }
    described: SceneParams = given.model_copy(update=changes)
    return compile_scene("any", described, declared, root)
