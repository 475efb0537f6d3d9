"""The robot's gripper: which actuators close it, and whether it would close on the target."""

from __future__ import annotations

import math
from dataclasses import dataclass

import mujoco
import numpy as np

from pipeline.sim.robot import arm_actuators
from pipeline.sim.scene import Scene, initial_data

_OF_CLEARANCE = 1 / 4  # the Panda's finger itself takes most of the rest
_JOINTS = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))


@dataclass(frozen=True, eq=False)
class Gripper:
    """Fingers that actuators move; all arrays are (n,), none where the robot has no such finger.

    Attributes:
        actuators: numbers in the model.
        joints: of the fingers, numbers in the model.
        opened, closed: controls, which are also joint positions.
    """

    actuators: np.ndarray
    joints: np.ndarray
    opened: np.ndarray
    closed: np.ndarray

    @property
    def exists(self) -> bool:
        return bool(len(self.actuators))

    def open(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Stands the fingers open, at once."""
        data.qpos[model.jnt_qposadr[self.joints]] = self.opened
        data.ctrl[self.actuators] = self.opened

    def command(self, data: mujoco.MjData, close: bool) -> None:
        """Has the actuators open or close the fingers from now on."""
        data.ctrl[self.actuators] = self.closed if close else self.opened

    def distance_m(self, model: mujoco.MjModel, data: mujoco.MjData, tip: int, point_m: np.ndarray) -> float:
        """How far a point is from what lies between the fingers' pads.

        Sliding fingers meet at the tip when they are closed, so a pad is as far from it as its joint is open,
        along the joint's axis. Where fingers do not slide, what lies between them is the tip itself.

        Args:
            tip: the site.
            point_m: shape (3,), m.
        """
        place = data.site_xpos[tip]
        slides = model.jnt_type[self.joints] == mujoco.mjtJoint.mjJNT_SLIDE
        opening = data.qpos[model.jnt_qposadr[self.joints]] - self.closed
        pads = place + data.xaxis[self.joints] * (opening * slides)[:, None]
        pads = pads if len(pads) else place[None]
        return min(_from_segment_m(point_m, a, b) for a in pads for b in pads)


def _from_segment_m(point: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    along = b - a
    share = np.clip((point - a) @ along / max(float(along @ along), 1e-18), 0.0, 1.0)
    return float(np.linalg.norm(point - (a + share * along)))


def gripper_of(scene: Scene) -> Gripper:
    """The gripper of the scene's robot: position actuators of joints beyond the body of the tip.

    Which end of such an actuator's range is the open one follows from the model: there the finger is farther
    from the tip. Where there are obstacles, fingers open by :data:`_OF_CLEARANCE` of the obstacles' clearance
    only: starts and targets are that near to obstacles, and the model's gripper is closed.
    """
    model, arm = scene.model, set(arm_actuators(scene.model, scene.robot).tolist())
    hand = int(model.site_bodyid[scene.tip_site])
    found = [
        (actuator, int(model.actuator_trnid[actuator, 0]))
        for actuator in range(model.nu)
        if actuator not in arm
        and int(model.actuator_trntype[actuator]) in _JOINTS
        and model.actuator_ctrllimited[actuator]
        and _is_below(model, int(model.jnt_bodyid[model.actuator_trnid[actuator, 0]]), hand)
    ]
    clearance_m = scene.params.obstacle_clearance_m if scene.params.obstacles else math.inf
    ends = [_ends(scene, actuator, joint, _OF_CLEARANCE * clearance_m) for actuator, joint in found]
    return Gripper(
        actuators=np.array([actuator for actuator, _ in found], dtype=int),
        joints=np.array([joint for _, joint in found], dtype=int),
        opened=np.array([end[0] for end in ends], dtype=float),
        closed=np.array([end[1] for end in ends], dtype=float),
    )


def _is_below(model: mujoco.MjModel, body: int, ancestor: int) -> bool:
    while body > 0 and body != ancestor:
        body = int(model.body_parentid[body])
    return body == ancestor


def _ends(scene: Scene, actuator: int, joint: int, most: float) -> tuple[float, float]:
    """The open end of an actuator's range, at most so far from the closed one, and the closed one."""
    model, data = scene.model, initial_data(scene)
    low, high = model.actuator_ctrlrange[actuator]
    reach = []
    for end in (low, high):
        data.qpos[model.jnt_qposadr[joint]] = end
        mujoco.mj_kinematics(model, data)
        finger = data.xipos[model.jnt_bodyid[joint]]
        reach.append(float(np.linalg.norm(finger - data.site_xpos[scene.tip_site])))
    opened, closed = (high, low) if reach[1] > reach[0] else (low, high)
    return closed + float(np.clip(opened - closed, -most, most)), float(closed)
