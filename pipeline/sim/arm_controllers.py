"""How an action becomes a motion: a displacement of the tip, for a whole batch of worlds at once.

An action is a share of the largest displacement per controlled axis, in [-1, 1]. It is counted from
where the tip is, as in panda-gym and FetchReach, so a blocked tip winds nothing up; the setpoint place
is kept within the workspace, and the axes that are not controlled stay where the episode began.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from pipeline.contract.errors import BelvedereError
from pipeline.sim.robot import arm_actuators, held_controls, joint_ranges
from pipeline.sim.scene import Scene, initial_data
from pipeline.sim.wheel_robots import UPRIGHT

DAMPING = 1e-3  # of the least squares, keeps joint steps finite near singular postures
NEWTON_STEPS = 2  # per frame; a displacement of 0.05 m is solved to well below 1 mm
_SETUP_STEPS = 100
TOLERANCE_M = 1e-3


Fields = dict[str, np.ndarray]  # MjData fields to be written, each with a leading axis over worlds


@dataclass(frozen=True, eq=False)
class TipPose:
    """Where each world's hand is: tip and body places (n, 3), m, and body orientation (n, 4)."""

    tip_m: np.ndarray
    body_m: np.ndarray
    body_quaternion: np.ndarray


class ArmController(Protocol):
    """Turns setpoint tip places into fields of ``count`` simulations; it holds no simulation itself."""

    def reset(self, start_m: np.ndarray, target_m: np.ndarray) -> Fields:
        """The state with every tip at its start, at rest; shapes (n, 3), m."""

    def move(self, tip_pose: TipPose, setpoint_m: np.ndarray) -> Fields:
        """The controls that bring each tip towards its setpoint place; shape (n, 3), m."""


def next_setpoint(scene: Scene, tip_m: np.ndarray, start_m: np.ndarray, action: np.ndarray) -> np.ndarray:
    """Where the tip should go: shapes (n, 3), (n, 3) and (n, action_size) → (n, 3), m."""
    axes = list(scene.axes)
    low = np.asarray(scene.params.workspace.low_m)[axes]
    high = np.asarray(scene.params.workspace.high_m)[axes]
    setpoint = start_m.copy()
    step = scene.params.displacement_m * np.clip(action, -1.0, 1.0)
    setpoint[:, axes] = np.clip(tip_m[:, axes] + step, low, high)
    return setpoint


class JointController:
    """Inverse kinematics, batched over worlds, to a position actuator per joint (Panda).

    The joint commands of each world live in a second batch over the same model that is never
    stepped: damped least squares on its tip pose, from the last command, keeps the hand upright.
    """

    def __init__(self, scene: Scene, count: int, threads: int) -> None:
        self._scene, self._count = scene, count
        model = scene.model
        joints = [model.joint(name) for name in scene.robot.arm]
        self._dofs = np.array([j.dofadr[0] for j in joints])
        self._coordinates = np.array([j.qposadr[0] for j in joints])
        self._low, self._high = joint_ranges(model, scene.robot.arm)
        self._body = int(model.site_bodyid[scene.tip_site])
        home = initial_data(scene)
        self._home_qpos = home.qpos.copy()
        self._upright = home.site_xmat[scene.tip_site].reshape(3, 3).copy()
        self._ik_state = mujoco_batch.Batch(model, count, threads)
        self._qpos = self._ik_state.bind("qpos")
        self._places = self._ik_state.bind("site_xpos")
        self._rotations = self._ik_state.bind("site_xmat")
        self._rows = slice(0, 6 if scene.robot.keeps_pose else 3)
        self._damping = DAMPING**2 * np.eye(self._rows.stop)
        self._most = scene.declared.drive.largest_step / NEWTON_STEPS
        self._actuators = arm_actuators(model, scene.robot)
        self._controls = np.tile(held_controls(model, scene.robot), (count, 1))

    def reset(self, start_m: np.ndarray, target_m: np.ndarray) -> Fields:
        self._refuse_unreached(start_m, self.solve(start_m))
        mocap = np.zeros((self._count, self._scene.model.nmocap, 3))
        mocap[:, self._scene.target_mocap] = target_m
        rest = np.zeros((self._count, self._scene.model.nv))
        state = {"qpos": self._qpos.copy(), "mocap_pos": mocap, "qacc_warmstart": rest}
        return {**state, "ctrl": self._commands()}

    def move(self, tip_pose: TipPose, setpoint_m: np.ndarray) -> Fields:
        for _ in range(NEWTON_STEPS):
            self._newton(setpoint_m)
        return {"ctrl": self._commands()}

    def _commands(self) -> np.ndarray:
        self._controls[:, self._actuators] = self._qpos[:, self._coordinates]
        return self._controls

    def _newton(self, setpoint_m: np.ndarray, enough_m: float = -1.0) -> np.ndarray:
        """One damped least-squares step of the worlds farther off than ``enough_m``; returns which.

        Each world stops on its own account, or its last bits would depend on its neighbours.
        """
        site = self._scene.tip_site
        self._ik_state.forward(stage=mujoco.mjtStage.mjSTAGE_POS)
        place = self._places[:, site].copy()
        rotation = self._rotations[:, site].reshape(-1, 3, 3)
        along, about = self._ik_state.jac(self._body, place)
        jacobian = np.concatenate([along, about], axis=1)[:, self._rows, self._dofs]
        # rotation error as a vector: half the sum of cross products of matching axes
        tilt = 0.5 * np.cross(rotation.transpose(0, 2, 1), self._upright.T[None]).sum(axis=1)
        error = np.concatenate([setpoint_m - place, tilt], axis=1)[:, self._rows]
        gram = jacobian @ jacobian.transpose(0, 2, 1) + self._damping
        step = jacobian.transpose(0, 2, 1) @ np.linalg.solve(gram, error[:, :, None])
        step *= self._most / np.maximum(np.abs(step).max(axis=1, keepdims=True), self._most)
        off = np.linalg.norm(setpoint_m - place, axis=1) > enough_m
        moved = self._qpos[:, self._coordinates] + step[:, :, 0] * off[:, None]
        self._qpos[:, self._coordinates] = np.clip(moved, self._low, self._high)
        return off

    def solve(self, tip_m: np.ndarray) -> np.ndarray:
        """Turns the joints, from home, until tips are at places (n, 3), m; returns what is left (n,), m."""
        self._qpos[:] = self._home_qpos
        for _ in range(_SETUP_STEPS):
            if not self._newton(tip_m, enough_m=TOLERANCE_M / 10).any():
                break
        self._ik_state.forward(stage=mujoco.mjtStage.mjSTAGE_POS)
        return np.asarray(np.linalg.norm(self._places[:, self._scene.tip_site] - tip_m, axis=1))

    def _refuse_unreached(self, start_m: np.ndarray, missed: np.ndarray) -> None:
        if missed.max() > TOLERANCE_M:
            point = np.round(start_m[int(missed.argmax())], 3).tolist()
            raise BelvedereError(
                f"scene {self._scene.name}: the robot cannot bring its tip to {point} m (it stays "
                f"{missed.max():.3f} m away); move the scene's start, target or workspace in params.yaml."
            )


class MocapController:
    """A weld to a mocap body pulls the tip, as in FetchReach: from where the body is, each frame.

    A tilted hand is turned back most of the way: ``UPRIGHT`` is added to its quaternion (MuJoCo
    normalizes the sum), as gymnasium-robotics does.
    """

    def __init__(self, scene: Scene, count: int, threads: int) -> None:
        self._scene, self._count = scene, count
        self._mocap = int(scene.model.body(scene.robot.mocap).mocapid[0])
        self._settled = initial_data(scene)
        self._mocap_pos = np.repeat(self._settled.mocap_pos[None], count, axis=0)
        self._mocap_quat = np.repeat(self._settled.mocap_quat[None], count, axis=0)

    def reset(self, start_m: np.ndarray, target_m: np.ndarray) -> Fields:
        home_tip = self._settled.site_xpos[self._scene.tip_site]
        missed = np.linalg.norm(start_m - home_tip, axis=1).max()
        if missed > 5 * TOLERANCE_M:
            raise BelvedereError(
                f"scene {self._scene.name}: episodes start {missed:.3f} m from the robot's own start "
                f"{np.round(home_tip, 4).tolist()} m; set scenes.{self._scene.name}.start to it."
            )
        self._mocap_pos[:] = self._settled.mocap_pos
        self._mocap_quat[:] = self._settled.mocap_quat
        self._mocap_pos[:, self._scene.target_mocap] = target_m
        moving = ("qpos", "qvel", "qacc_warmstart")
        state = {f: np.repeat(getattr(self._settled, f)[None], self._count, axis=0) for f in moving}
        return {**state, "mocap_pos": self._mocap_pos, "mocap_quat": self._mocap_quat}

    def move(self, tip_pose: TipPose, setpoint_m: np.ndarray) -> Fields:
        self._mocap_pos[:, self._mocap] = tip_pose.body_m + (setpoint_m - tip_pose.tip_m)
        self._mocap_quat[:, self._mocap] = tip_pose.body_quaternion + np.array(UPRIGHT)
        return {"mocap_pos": self._mocap_pos, "mocap_quat": self._mocap_quat}


def arm_controller(scene: Scene, count: int, threads: int) -> ArmController:
    """The controller of the scene's robot."""
    kinds: dict[str, Callable[[Scene, int, int], ArmController]] = {
        "joints": JointController,
        "weld": MocapController,
    }
    return kinds[scene.robot.control](scene, count, threads)
