"""The arm controllers of :mod:`pipeline.sim.arm_controllers` as Warp kernels, for worlds kept on a device."""

# mypy: disable-error-code="misc, index"
# (a kernel is no Python: its values have other types inside than outside)

from __future__ import annotations

from typing import Any, Protocol

import mujoco_warp as mjw
import numpy as np
import warp as wp

from pipeline.cuda import ik
from pipeline.sim.arm_controllers import NEWTON_STEPS, Fields
from pipeline.sim.robot import arm_actuators
from pipeline.sim.scene import Scene
from pipeline.sim.wheel_robots import UPRIGHT

wp.set_module_options({"enable_backward": False})

_UPRIGHT = wp.constant(wp.quat(*UPRIGHT))  # w first, as MuJoCo has it


class DeviceArmController(Protocol):
    """Turns setpoints into fields of ``count`` simulations, without the host."""

    def reset(self, fields: Fields) -> None:
        """Begins with the state that :meth:`pipeline.sim.arm_controllers.ArmController.reset` gives."""

    def move(self, data: mjw.Data, tip: wp.array, setpoint: wp.array) -> None:
        """Writes the controls of ``data`` that bring each tip (n,) towards its setpoint place (n,), m."""


@wp.kernel
def write_setpoints(
    action: wp.array2d[float],
    tip: wp.array[wp.vec3],
    start: wp.array[wp.vec3],
    axes: wp.array[int],
    low: wp.vec3,
    high: wp.vec3,
    displacement_m: float,
    setpoint: wp.array[wp.vec3],
    refused: wp.array[int],
) -> None:
    """Where each tip should go; an action that is no number is counted in ``refused`` and moves nothing."""
    world = wp.tid()
    place = start[world]
    for index in range(axes.shape[0]):
        axis = axes[index]
        share = action[world, index]
        if not wp.isfinite(share):
            wp.atomic_add(refused, 0, 1)
            share = 0.0
        step = displacement_m * wp.clamp(share, -1.0, 1.0)
        place[axis] = wp.clamp(tip[world][axis] + step, low[axis], high[axis])
    setpoint[world] = place


class Setpoints:
    """Setpoints of ``count`` worlds; see :func:`pipeline.sim.arm_controllers.next_setpoint`."""

    def __init__(self, scene: Scene, count: int) -> None:
        self.start, self.setpoint = wp.zeros(count, dtype=wp.vec3), wp.zeros(count, dtype=wp.vec3)
        self.refused = wp.zeros(1, dtype=int)
        workspace = scene.params.workspace
        self._axes = wp.array(list(scene.axes), dtype=int)
        self._low, self._high = wp.vec3(*workspace.low_m), wp.vec3(*workspace.high_m)
        self._displacement_m = scene.params.displacement_m

    def make(self, action: wp.array, tip: wp.array) -> wp.array:
        """The places (n,), m, that actions (n, action_size) lead to from tips (n,)."""
        limits = [self._low, self._high, self._displacement_m]
        wp.launch(
            write_setpoints,
            dim=len(tip),
            inputs=[action, tip, self.start, self._axes, *limits],
            outputs=[self.setpoint, self.refused],
        )
        return self.setpoint


class DeviceJointController:
    """Inverse kinematics to position actuators; see :class:`pipeline.sim.arm_controllers.JointController`."""

    def __init__(self, scene: Scene, model: mjw.Model, count: int) -> None:
        self._model = model
        self._ik_state = mjw.make_data(scene.model, nworld=count, nconmax=1, njmax=1)
        self._arm = ik.arm(scene)
        self._actuators = wp.array(arm_actuators(scene.model, scene.robot), dtype=int)

    def reset(self, fields: Fields) -> None:
        self._ik_state.qpos.assign(np.asarray(fields["qpos"], dtype=np.float32))

    def move(self, data: mjw.Data, tip: wp.array, setpoint: wp.array) -> None:
        for _ in range(NEWTON_STEPS):
            ik.newton(self._model, self._ik_state, self._arm, setpoint)
        wp.launch(
            command,
            dim=(len(setpoint), len(self._actuators)),
            inputs=[self._ik_state.qpos, self._arm.coordinates, self._actuators],
            outputs=[data.ctrl],
        )


@wp.kernel
def command(
    qpos: wp.array2d[float], coordinates: wp.array[int], actuators: wp.array[int], ctrl: wp.array2d[float]
) -> None:
    """Commands the arm's actuators to their joints' positions; the others stay at what :meth:`reset` had."""
    world, index = wp.tid()
    ctrl[world, actuators[index]] = qpos[world, coordinates[index]]


class DeviceMocapController:
    """A weld to a mocap body; see :class:`pipeline.sim.arm_controllers.MocapController`."""

    def __init__(self, scene: Scene, model: mjw.Model, count: int) -> None:
        self._body = int(scene.model.site_bodyid[scene.tip_site])
        self._mocap = int(scene.model.body(scene.robot.mocap).mocapid[0])

    def reset(self, fields: Fields) -> None:
        """Keeps nothing of an episode."""

    def move(self, data: mjw.Data, tip: wp.array, setpoint: wp.array) -> None:
        wp.launch(
            pull,
            dim=len(tip),
            inputs=[data.xpos, data.xquat, self._body, tip, setpoint, self._mocap],
            outputs=[data.mocap_pos, data.mocap_quat],
        )


@wp.kernel
def pull(
    place: wp.array2d[wp.vec3],
    rotation: wp.array2d[wp.quat],
    body: int,
    tip: wp.array[wp.vec3],
    setpoint: wp.array[wp.vec3],
    mocap: int,
    mocap_place: wp.array2d[wp.vec3],
    mocap_turn: wp.array2d[wp.quat],
) -> None:
    """Sets the mocap body to where the hand is, moved by what the tip lacks and turned towards upright."""
    world = wp.tid()
    mocap_place[world, mocap] = place[world, body] + (setpoint[world] - tip[world])
    mocap_turn[world, mocap] = rotation[world, body] + _UPRIGHT


def device_arm_controller(scene: Scene, model: mjw.Model, count: int) -> DeviceArmController:
    """The controller of the scene's robot, on Warp's current device."""
    kinds: dict[str, Any] = {"joints": DeviceJointController, "weld": DeviceMocapController}
    made: DeviceArmController = kinds[scene.robot.control](scene, model, count)
    return made
