"""A robot from any MJCF or URDF file, attached to a scene under the prefix ``robot/``."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np

from pipeline.contract.errors import BelvedereError
from pipeline.sim import servos
from pipeline.sim.foreign import cleaned, found
from pipeline.sim.obj_meshes import join_objects
from pipeline.sim.postures import home_posture
from pipeline.sim.robot import HIDDEN_GROUP, TIP, Robot, chain
from pipeline.sim.robot_files import files_read
from pipeline.sim.robot_params import RobotParams, Tip
from pipeline.sim.urdf import urdf_text

PREFIX = "robot/"
_SIZES = ("actuator", "body", "cam", "geom", "jnt", "sensor", "site", "tendon")
_SETTINGS = (
    *("option", "visual", "stat", "memory", "nconmax", "njmax", "nstack"),
    *(f"nuser_{kind}" for kind in _SIZES),
)
_POSE = 6  # numbers that make a pose: an arm of fewer joints cannot keep one


def attached(name: str, declared: RobotParams, file: Path) -> tuple[mujoco.MjSpec, Robot]:
    """A new scene with the robot in it; what the file says of light, sky, cameras, options is left out.

    Raises:
        BelvedereError: the file and the declaration do not fit, or the file holds what no arm has.
    """
    spec, files = _read(name, file)
    model = _compiled(name, file, spec)
    dropped = cleaned(name, file, spec, declared.remove)
    body = _tip_body(name, file, spec, declared.tip)
    place, rotation = _tip_pose(model, declared.tip)
    arm = _arm(name, file, body, declared)
    drives = servos.prepare(name, file, spec, arm, declared, model)
    posture = home_posture(name, file, [joint.name for joint in spec.joints], model, declared)
    touching = _far_links(body, arm)
    if declared.gravity == "compensated":
        for each in spec.bodies[1:]:
            each.gravcomp = 1.0
    whole = _attach(spec, declared)
    servos.add(whole, [PREFIX + joint for joint in drives.made])
    body.add_site(name=TIP, pos=place, quat=rotation, group=HIDDEN_GROUP)
    held = {PREFIX + actuator: value for actuator, value in drives.held.items()}
    held |= {servos.name_of(PREFIX + j): posture[j] for j in drives.made if j not in arm}
    robot = Robot(
        name=name,
        control="joints",
        home={PREFIX + joint: value for joint, value in posture.items()},
        prefix=PREFIX,
        arm=tuple(PREFIX + joint for joint in arm),
        touching=frozenset(PREFIX + link for link in touching),
        files=tuple(files),
        keeps_pose=declared.drive.keeps == "pose",
        held=held,
        made=tuple(PREFIX + joint for joint in drives.made),
        dropped=tuple(dropped),
    )
    return whole, robot


def _read(name: str, file: Path) -> tuple[mujoco.MjSpec, list[Path]]:
    """The file's spec, whose bodies, joints, actuators and keys all have names, and the files it takes."""
    if file.suffix.lower() == ".urdf":
        text, files = urdf_text(name, file)
        spec = mujoco.MjSpec.from_string(text)
    else:
        files = files_read(name, file)
        spec = mujoco.MjSpec.from_file(str(file))
    for kind in ("body", "joint", "actuator", "key"):
        for number, element in enumerate(getattr(spec, "bodies" if kind == "body" else f"{kind}s")):
            element.name = element.name or f"{kind}_{number}"
    join_objects(spec)
    return spec, files


def _compiled(name: str, file: Path, spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model of the file by itself."""
    model = spec.compile()
    if not model.njnt:
        raise BelvedereError(f"robot {name}: {file.name} holds no joint, so nothing in it can move.")
    return model


def _tip_body(name: str, file: Path, spec: mujoco.MjSpec, tip: Tip) -> mujoco.MjsBody:
    """The body to which the tip is fixed."""
    if tip.body is not None:
        return found(name, file, "body for the tip", tip.body, spec.bodies[1:])
    return found(name, file, "site for the tip", tip.site or "", spec.sites).parent


def _tip_pose(model: mujoco.MjModel, tip: Tip) -> tuple[np.ndarray, np.ndarray]:
    """Place (3,), m, and quaternion (4,) of the tip in its body's frame."""
    if tip.site is None:
        return np.asarray(tip.offset_m), np.array([1.0, 0.0, 0.0, 0.0])
    site, turned = model.site(tip.site), np.zeros(3)
    mujoco.mju_rotVecQuat(turned, np.asarray(tip.offset_m), site.quat)
    return site.pos + turned, site.quat


def _arm(name: str, file: Path, body: mujoco.MjsBody, declared: RobotParams) -> list[str]:
    """The joints that carry the tip, from the base on."""
    arm = [joint.name for carrier in chain(body) for joint in carrier.joints]
    if not arm:
        raise BelvedereError(
            f"robot {name}: no joint of {file.name} carries the tip, which is fixed to body {body.name}; "
            "name a site or body beyond the last joint."
        )
    if len(arm) < _POSE and declared.drive.keeps == "pose":
        raise BelvedereError(
            f"robot {name}: {len(arm)} joints of {file.name} carry the tip ({', '.join(arm)}), and a pose "
            f"takes {_POSE} to keep; free the tip's orientation by robots.{name}.drive.keeps: place."
        )
    return arm


def _far_links(body: mujoco.MjsBody, arm: list[str]) -> set[str]:
    """The bodies from the forearm on: those that the middle joint of the arm, or one beyond it, moves."""
    middle = arm[(len(arm) - 1) // 2]
    carriers = chain(body)
    at = next(i for i, carrier in enumerate(carriers) if middle in {joint.name for joint in carrier.joints})
    links, waiting = set(), [carriers[at]]
    while waiting:
        link = waiting.pop()
        links.add(link.name)
        waiting += list(link.bodies)
    return links


def _attach(spec: mujoco.MjSpec, declared: RobotParams) -> mujoco.MjSpec:
    whole = mujoco.MjSpec()
    whole.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    for setting in _SETTINGS:  # the scene's count; MuJoCo would warn of each that differs
        setattr(spec, setting, getattr(whole, setting))
    half = math.radians(declared.base.turn_deg) / 2
    turned = [math.cos(half), 0.0, 0.0, math.sin(half)]
    frame = whole.worldbody.add_frame(pos=declared.base.position_m, quat=turned)
    whole.attach(spec, prefix=PREFIX, frame=frame)
    return whole
