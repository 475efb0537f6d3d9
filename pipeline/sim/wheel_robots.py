"""Panda and Fetch, from the gymnasium-robotics wheel: what their files need beyond the rules for any file."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from pipeline.sim.foreign import found
from pipeline.sim.robot import HIDDEN_GROUP, TIP, Robot
from pipeline.sim.robot_files import files_read, require
from pipeline.sim.robot_params import RobotParams

_FINGER_RGBA = (0.25, 0.25, 0.27, 1.0)  # the real Panda's hand and fingers are darker than its arm
# The kitchen's Panda makes 15 mm a frame at full push; half damped about 25, nearer to Fetch's 33.
_PANDA_DAMPING_SHARE = 0.5
_PANDA_TOUCHES = ("link5", "link6", "link7", "leftfinger", "rightfinger")
_FETCH_MOCAP = "robot0:mocap"
_FETCH_TOUCHES = (
    "elbow_flex_link",
    "forearm_roll_link",
    "wrist_flex_link",
    "wrist_roll_link",
    "gripper_link",
    "r_gripper_finger_link",
    "l_gripper_finger_link",
)


def kitchen_panda(name: str, declared: RobotParams, file: Path) -> tuple[mujoco.MjSpec, Robot]:
    """The Panda of the kitchen model, whose parts are includes: ``file`` is the one with the arm."""
    includes = [file.with_name("assets.xml"), file, file.with_name("actuator.xml")]
    for path in includes:
        require(path, f"robot {name}: {path.name}, which belongs to {declared.file},")
    assets, arm, actuator = (f'<include file="{path}"/>' for path in includes)
    spec = mujoco.MjSpec.from_string(f"<mujoco>{assets}<worldbody>{arm}</worldbody>{actuator}</mujoco>")
    for mesh in spec.meshes:  # the include's own folder stands in the paths, without its mesh folder
        mesh.file = str(file.parent / "meshes" / Path(mesh.file).parent.name / Path(mesh.file).name)
        require(Path(mesh.file), f"robot {name}: a mesh of {declared.file}")
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0  # the real arm's controller carries its own weight
    for joint in spec.joints:
        joint.damping = np.asarray(joint.damping) * _PANDA_DAMPING_SHARE
    for geom in spec.geoms:
        if geom.meshname in ("hand_viz", "finger_viz"):
            geom.rgba = _FINGER_RGBA
    joints = tuple(joint.name for joint in spec.joints if "finger" not in joint.name)
    home = declared.home if isinstance(declared.home, dict) else {}
    for joint in home:
        found(name, file, "joint below home", joint, [j for j in spec.joints if j.name in joints])
    _add_tip(name, file, spec, declared)
    robot = Robot(
        name=name,
        control="joints",
        home={joint: home.get(joint, 0.0) for joint in joints},
        prefix="panda0_",
        arm=joints,
        touching=frozenset(f"panda0_{body}" for body in _PANDA_TOUCHES),
        files=(file, includes[0], includes[2], *(Path(mesh.file) for mesh in spec.meshes)),
        keeps_pose=declared.drive.keeps == "pose",
    )
    return spec, robot


def fetch_reach(name: str, declared: RobotParams, file: Path) -> tuple[mujoco.MjSpec, Robot]:
    """Fetch with FetchReach's table."""
    spec = mujoco.MjSpec.from_file(str(file))
    for wanted in ("skybox", "light0"):
        for element in (spec.texture(wanted), spec.light(wanted)):
            if element is not None:
                spec.delete(element)
    for texture in list(spec.textures):
        spec.delete(texture)
    for weld in spec.equalities:  # the gripper's body coincides with the mocap body
        weld.data[3:10] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
    for geom in found(name, file, "mocap body", _FETCH_MOCAP, spec.bodies[1:]).geoms:
        geom.group = HIDDEN_GROUP
    _add_tip(name, file, spec, declared)
    robot = Robot(
        name=name,
        control="weld",
        home={},
        prefix="robot0:",
        arm=(),
        touching=frozenset(f"robot0:{body}" for body in _FETCH_TOUCHES),
        files=tuple(files_read(name, file)),
        mocap=_FETCH_MOCAP,
        settle=settle_fetch,
    )
    return spec, robot


def _add_tip(name: str, file: Path, spec: mujoco.MjSpec, declared: RobotParams) -> None:
    body = found(name, file, "body for the tip", declared.tip.body or "", spec.bodies[1:])
    body.add_site(name=TIP, pos=declared.tip.offset_m, group=HIDDEN_GROUP)


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
    mocap = model.body(_FETCH_MOCAP).mocapid[0]
    data.mocap_pos[mocap] = grip + np.array([-0.498, 0.005, -0.431 + 0.2])
    data.mocap_quat[mocap] = UPRIGHT
    mujoco.mj_step(model, data, nstep=200)
