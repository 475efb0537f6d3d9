"""What moves a robot's joints: position servos made by one rule for all arms, or the file's own.

A made servo has the stiffness (2 π f)² · I and the damping 2 ζ 2 π f · I, where I is the joint's inertia at
home. It takes the place of the joint's own damping, friction, spring and limit of force, so that arms whose
files say little of them, or too much, follow alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.sim.foreign import found
from pipeline.sim.postures import keyframe
from pipeline.sim.robot import Robot
from pipeline.sim.robot_params import Drive, RobotParams

_OF_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
_JOINT_TO_JOINT = mujoco.mjtEq.mjEQ_JOINT


@dataclass(frozen=True)
class Servos:
    """Names as in the robot's file.

    Attributes:
        made: joints that get a servo: those of the arm, unless the file's own move them, and any other joint
            that nothing else holds.
        held: controls of the file's actuators that move no joint of the arm.
    """

    made: tuple[str, ...]
    held: dict[str, float]


def name_of(joint: str) -> str:
    """The actuator made for a joint."""
    return f"servo {joint}"


def prepare(
    name: str, file: Path, spec: mujoco.MjSpec, arm: list[str], declared: RobotParams, model: mujoco.MjModel
) -> Servos:
    """Readies the spec's joints and actuators, and says which are to be made and held.

    Raises:
        BelvedereError: the file's own actuators are wanted, but are no position servos of the arm's joints;
            or an actuator to be held is unknown.
    """
    if declared.drive.actuators == "own":
        for joint in arm:
            _require_position_servo(name, file, spec, joint)
        made = []
    else:
        for actuator in [a for a in spec.actuators if a.trntype in _OF_JOINTS and a.target in arm]:
            spec.delete(actuator)
        made = list(arm)
    held = _held(name, file, [a for a in spec.actuators if a.target not in arm], declared, model)
    made += _loose(spec, set(arm))
    for joint in spec.joints:
        if joint.name in made:
            joint.damping = 0.0 * np.asarray(joint.damping)
            joint.stiffness = 0.0 * np.asarray(joint.stiffness)
            joint.frictionloss, joint.actfrclimited, joint.actgravcomp = 0.0, False, False
    return Servos(tuple(made), held)


def _held(
    name: str, file: Path, actuators: list[mujoco.MjsActuator], declared: RobotParams, model: mujoco.MjModel
) -> dict[str, float]:
    for wanted in declared.hold:
        found(name, file, "actuator to hold, which moves no joint of the arm,", wanted, actuators)
    controls = {a.name: 0.0 for a in actuators}
    if isinstance(declared.home, str):
        key = keyframe(name, file, model, declared.home)
        controls |= {a.name: float(key.ctrl[model.actuator(a.name).id]) for a in actuators}
    return controls | {actuator: float(value) for actuator, value in declared.hold.items()}


def _require_position_servo(name: str, file: Path, spec: mujoco.MjSpec, joint: str) -> None:
    """The joint's one actuator takes a joint position, and pulls towards it."""
    driving = [a for a in spec.actuators if a.trntype in _OF_JOINTS and a.target == joint]
    found_ = f"{len(driving)} actuators" if driving else "no actuator"
    if len(driving) == 1:
        own = driving[0]
        gain, bias = own.gainprm[0], own.biasprm
        affine = own.biastype == mujoco.mjtBias.mjBIAS_AFFINE and own.gaintype == mujoco.mjtGain.mjGAIN_FIXED
        straight = own.gear[0] == 1.0 and own.dyntype == mujoco.mjtDyn.mjDYN_NONE
        if affine and straight and gain > 0 and np.isclose(bias[1], -gain):
            return
        found_ = f"{own.name}, which is no position servo of gear 1,"
    raise BelvedereError(
        f"robot {name}: drive.actuators is own, but joint {joint} of {file.name} has {found_} to follow a "
        f"position with; set robots.{name}.drive.actuators: added."
    )


def _loose(spec: mujoco.MjSpec, arm: set[str]) -> list[str]:
    """Joints beside the arm's that no actuator, tendon, equality or spring holds, as a URDF's fingers."""
    if any(e.type != _JOINT_TO_JOINT for e in spec.equalities) or len(spec.tendons):
        return []  # a mechanism, whose joints hang together
    bound = {a.target for a in spec.actuators if a.trntype in _OF_JOINTS}
    bound |= {name for e in spec.equalities for name in (e.name1, e.name2)}
    return [
        j.name for j in spec.joints if j.name not in arm | bound and not np.any(np.asarray(j.stiffness) > 0)
    ]


def add(spec: mujoco.MjSpec, joints: list[str]) -> None:
    """Adds a servo for each joint; :func:`tune` gives it its stiffness once there is a model."""
    for joint in joints:
        spec.add_actuator(
            name=name_of(joint),
            target=joint,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        )


def tune(model: mujoco.MjModel, robot: Robot, drive: Drive) -> None:
    """Sets made servos' stiffness and damping by their joints' inertia at home."""
    data = mujoco.MjData(model)
    for joint, position in robot.home.items():
        data.joint(joint).qpos[:] = position
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    pulse = 2 * np.pi * drive.frequency_hz
    for joint in robot.made:
        number, dof = model.actuator(name_of(joint)).id, model.joint(joint).dofadr[0]
        stiffness = pulse**2 * inertia[dof, dof]
        damping = 2 * drive.damping_ratio * pulse * inertia[dof, dof]
        model.actuator_gainprm[number, 0] = stiffness
        model.actuator_biasprm[number, :3] = 0.0, -stiffness, -damping
