"""The posture from which a robot's inverse kinematics start."""

from __future__ import annotations

from pathlib import Path

import mujoco

from pipeline.contract.errors import BelvedereError, unknown
from pipeline.sim.robot_params import RobotParams


def home_posture(
    name: str, file: Path, joints: list[str], model: mujoco.MjModel, declared: RobotParams
) -> dict[str, float]:
    """Positions (rad, m) of ``joints``: the declared ones, else 0, or the middle of a range that lacks 0.

    Args:
        name: the robot.
        file: its file.
        joints: those of the file's joints that are part of the scene.
        model: the file's own model.
        declared: the robot's declaration.

    Raises:
        BelvedereError: a joint or keyframe is unknown, or a position lies outside its joint's range.
    """
    if isinstance(declared.home, str):
        key = keyframe(name, file, model, declared.home)
        return {joint: float(key.qpos[model.joint(joint).qposadr[0]]) for joint in joints}
    for joint in declared.home:
        if joint not in joints:
            raise unknown(f"robot {name}: joint below home (of {file.name})", joint, joints)
    return {joint: _position(name, file, model.joint(joint), declared.home.get(joint)) for joint in joints}


def keyframe(name: str, file: Path, model: mujoco.MjModel, wanted: str) -> mujoco._structs._MjModelKeyViews:
    """The file's keyframe of this name.

    Raises:
        BelvedereError: there is none; tells those that there are.
    """
    keys = [model.key(k).name for k in range(model.nkey)]
    if wanted not in keys:
        raise unknown(f"robot {name}: keyframe for home (of {file.name})", wanted, keys)
    return model.key(wanted)


def _position(name: str, file: Path, joint: mujoco._structs._MjModelJointViews, given: float | None) -> float:
    low, high = joint.range if model_limits(joint) else (-float("inf"), float("inf"))
    if given is None:
        return 0.0 if low <= 0.0 <= high else float(low + high) / 2
    if not low <= given <= high:
        raise BelvedereError(
            f"robot {name}: home.{joint.name} = {given:g} lies outside the joint's range [{low:.4g}, "
            f"{high:.4g}] in {file.name}."
        )
    return float(given)


def model_limits(joint: mujoco._structs._MjModelJointViews) -> bool:
    """Whether a model's joint has a range."""
    return bool(joint.limited[0])
