"""A robot in a compiled scene: its names there, and how it is moved."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import mujoco
import numpy as np

TIP = "tip"
HIDDEN_GROUP = 4  # geoms of this group are in no picture


@dataclass(frozen=True, eq=False)
class Robot:
    """How a robot stands in a scene's model and is moved. Names are those of the compiled model.

    Attributes:
        name: its name in params.yaml.
        control: ``joints`` (inverse kinematics to position actuators) or ``weld`` (to a mocap body).
        home: joint positions (rad, m) at which inverse kinematics starts.
        prefix: what the names of all its bodies begin with.
        arm: the joints that carry the tip, from the base on.
        touching: the bodies that can touch something: those that come near it.
        files: every file that was read to build it, the declared one first.
        keeps_pose: whether inverse kinematics hold the tip's orientation.
        held: controls of the actuators that move no joint of the arm; 0 of those that are not named.
        made: joints for which a servo was added.
        mocap: name of the mocap body, for ``control == "weld"``.
        settle: brings the robot to where episodes start, if it takes steps to get there.
        dropped: what of the file is not in the scene, for people.
    """

    name: str
    control: str
    home: dict[str, float]
    prefix: str
    arm: tuple[str, ...]
    touching: frozenset[str]
    files: tuple[Path, ...]
    keeps_pose: bool = True
    held: dict[str, float] = field(default_factory=dict)
    made: tuple[str, ...] = ()
    mocap: str = ""
    settle: Callable[[mujoco.MjModel, mujoco.MjData], None] | None = None
    dropped: tuple[str, ...] = ()


def chain(body: mujoco.MjsBody) -> list[mujoco.MjsBody]:
    """A body and those that carry it, from the base on, without the world."""
    found = []
    while body is not None and body.name != "world":
        found.append(body)
        body = body.parent
    return found[::-1]


def arm_actuators(model: mujoco.MjModel, robot: Robot) -> np.ndarray:
    """The actuator of each of the arm's joints, in their order."""
    driven = {int(model.actuator_trnid[a, 0]): a for a in range(model.nu) if _drives_a_joint(model, a)}
    return np.array([driven[model.joint(name).id] for name in robot.arm], dtype=int)


def _drives_a_joint(model: mujoco.MjModel, actuator: int) -> bool:
    kinds = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    return int(model.actuator_trntype[actuator]) in map(int, kinds)


def held_controls(model: mujoco.MjModel, robot: Robot) -> np.ndarray:
    """Controls of all actuators, shape (nu,), with 0 for those of the arm."""
    controls = np.zeros(model.nu)
    for name, value in robot.held.items():
        controls[model.actuator(name).id] = value
    return controls


def joint_ranges(model: mujoco.MjModel, names: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper ends, each (n,), of joints' ranges; infinite where a joint has none."""
    joints = [model.joint(name).id for name in names]
    limited = model.jnt_limited[joints].astype(bool)
    low, high = model.jnt_range[joints].T
    return np.where(limited, low, -np.inf), np.where(limited, high, np.inf)
