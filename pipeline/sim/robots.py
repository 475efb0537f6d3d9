"""The robots: MJCF and meshes from the gymnasium-robotics wheel, as MuJoCo model specs.

A robot is a function that returns a spec with a site :data:`TIP`, and, for robots that are moved by
joint commands, one position actuator per joint. To add one, write such a function and name it in
:data:`ROBOTS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import mujoco
import numpy as np

from pipeline.contract.errors import BelvedereError, unknown

TIP = "tip"
HIDDEN_GROUP = 4  # geoms of this group are in no picture
_FINGER_RGBA = (0.25, 0.25, 0.27, 1.0)  # the real Panda's hand and fingers are darker than its arm
# The kitchen's Panda makes 15 mm a frame at full push; half damped about 25, nearer to Fetch's 33.
_PANDA_DAMPING_SHARE = 0.5


@dataclass(frozen=True)
class Robot:
    """How a robot is built and moved.

    Attributes:
        build: returns the robot's spec.
        control: ``joints`` (inverse kinematics to position actuators) or ``mocap`` (a weld pulls the tip).
        home: joint positions (rad) at which inverse kinematics starts, by joint name.
        prefix: what the names of all its bodies begin with.
        touching: the bodies (without the prefix) that can touch something: those that come near it.
        mocap: name of the mocap body, for ``control == "mocap"``.
    """

    build: Callable[[], mujoco.MjSpec]
    control: str
    home: dict[str, float]
    prefix: str
    touching: tuple[str, ...]
    mocap: str = ""


def robot(name: str) -> Robot:
    """The robot called ``name``; an unknown name is told with the known ones."""
    if name not in ROBOTS:
        raise unknown("robot", name, ROBOTS)
    return ROBOTS[name]


def _assets(*parts: str) -> Path:
    package = find_spec("gymnasium_robotics")
    if package is None or not package.submodule_search_locations:
        raise BelvedereError("package gymnasium-robotics, which brings the robots, is missing; run `./run`.")
    path = Path(package.submodule_search_locations[0], "envs", "assets", *parts)
    if not path.exists():
        raise BelvedereError(f"robot file {path} is missing; reinstall gymnasium-robotics (`./run`).")
    return path


def _panda() -> mujoco.MjSpec:
    folder = _assets("kitchen_franka", "franka_assets")
    includes = [
        _assets("kitchen_franka", "franka_assets", f"{n}.xml") for n in ("assets", "chain", "actuator")
    ]
    assets, chain, actuator = (f'<include file="{path}"/>' for path in includes)
    spec = mujoco.MjSpec.from_string(f"<mujoco>{assets}<worldbody>{chain}</worldbody>{actuator}</mujoco>")
    for mesh in spec.meshes:  # the include's own folder stands in the paths, without its mesh folder
        mesh.file = str(folder / "meshes" / Path(mesh.file).parent.name / Path(mesh.file).name)
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0  # the real arm's controller carries its own weight
    for joint in spec.joints:
        joint.damping = np.asarray(joint.damping) * _PANDA_DAMPING_SHARE
    hand = spec.body("panda0_link7")
    hand.add_site(name=TIP, pos=[0.0, 0.0, 0.235], group=HIDDEN_GROUP)  # between the finger pads
    for geom in spec.geoms:
        if geom.meshname in ("hand_viz", "finger_viz"):
            geom.rgba = _FINGER_RGBA
    return spec


def _fetch() -> mujoco.MjSpec:
    spec = mujoco.MjSpec.from_file(str(_assets("fetch", "reach.xml")))
    for name in ("skybox", "light0"):
        for element in (spec.texture(name), spec.light(name)):
            if element is not None:
                spec.delete(element)
    for texture in list(spec.textures):
        spec.delete(texture)
    for weld in spec.equalities:  # the gripper's body coincides with the mocap body
        weld.data[3:10] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    for geom in spec.body("robot0:mocap").geoms:
        geom.group = HIDDEN_GROUP
    spec.body("robot0:gripper_link").add_site(name=TIP, pos=[0.02, 0.0, 0.0], group=HIDDEN_GROUP)
    return spec


def limit_contacts(spec: mujoco.MjSpec, arm: Robot) -> None:
    """Leaves, in a whole scene, only contacts of the robot's ``touching`` bodies with what is not the robot.

    A robot that keeps its tip in a workspace does not touch itself; looking whether it does costs time
    in every substep.
    """
    for geom in spec.geoms:
        if not geom.contype and not geom.conaffinity:
            continue
        name = geom.parent.name
        geom.contype = int(name.removeprefix(arm.prefix) in arm.touching)
        geom.conaffinity = int(not name.startswith(arm.prefix))


UPRIGHT = (1.0, 0.0, 1.0, 0.0)  # quaternion, not normalized: Fetch's gripper points down


def settle_fetch(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    """Brings Fetch from its MJCF pose to where FetchReach episodes start (gymnasium-robotics).

    The base is placed, the weld is set to hold position and orientation, and the gripper is pulled
    to its start for 200 steps of 2 ms.
    """
    placed = {"robot0:slide0": 0.4049, "robot0:slide1": 0.48, "robot0:slide2": 0.0}
    for joint, value in placed.items():
        data.joint(joint).qpos[:] = value
    mujoco.mj_forward(model, data)
    grip = data.site(TIP).xpos.copy()
    mocap = model.body("robot0:mocap").mocapid[0]
    data.mocap_pos[mocap] = grip + np.array([-0.498, 0.005, -0.431 + 0.2])
    data.mocap_quat[mocap] = UPRIGHT
    mujoco.mj_step(model, data, nstep=200)


ROBOTS = {
    "panda": Robot(
        build=_panda,
        control="joints",
        home={
            "robot:panda0_joint1": 0.0,
            "robot:panda0_joint2": -0.2,
            "robot:panda0_joint3": 0.0,
            "robot:panda0_joint4": -2.2,
            "robot:panda0_joint5": 0.0,
            "robot:panda0_joint6": 0.45,
            "robot:panda0_joint7": 0.0,
        },
        prefix="panda0_",
        touching=("link5", "link6", "link7", "leftfinger", "rightfinger"),
    ),
    "fetch": Robot(
        build=_fetch,
        control="mocap",
        home={},
        prefix="robot0:",
        touching=(
            "elbow_flex_link",
            "forearm_roll_link",
            "wrist_flex_link",
            "wrist_roll_link",
            "gripper_link",
            "r_gripper_finger_link",
            "l_gripper_finger_link",
        ),
        mocap="robot0:mocap",
    ),
}
