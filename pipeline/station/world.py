"""One world of a scene, frame by frame: :class:`pipeline.sim.worlds.Worlds` of one, whose gripper closes.

Model, start, arm controller and workspace are those of the model's episodes; with the gripper kept closed, as
the model has it, tip and joints are the same bit for bit.
"""

from __future__ import annotations

import mujoco
import numpy as np

from pipeline.sim.arm_controllers import TipPose, arm_controller, next_setpoint
from pipeline.sim.draws import Episodes
from pipeline.sim.expert import Expert
from pipeline.sim.scene import Scene
from pipeline.sim.tasks.base import State
from pipeline.sim.worlds import start_fields
from pipeline.station.gripper import gripper_of

_HOME_M = 0.005  # so near to its start the tip is back: friction holds it on the last of the way


class World:
    """A scene's simulation and its gripper.

    Args:
        scene: the compiled scene.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene, self.gripper = scene, gripper_of(scene)
        self._data = mujoco.MjData(scene.model)
        self._controller = arm_controller(scene, 1, 1)
        self._hand = int(scene.model.site_bodyid[scene.tip_site])
        self._expert = Expert(scene)
        self._start = np.zeros((1, 3))
        self._closes = False

    def reset(self, start_m: np.ndarray, target_m: np.ndarray, opened: bool = True) -> None:
        """Stands the tip at its start, shape (3,), m, before the target, with the gripper open."""
        mujoco.mj_resetData(self.scene.model, self._data)
        self._start = np.array(start_m, dtype=np.float64)[None]
        episode = Episodes.at(self._start, np.array(target_m, dtype=np.float64)[None])
        self._write(start_fields(self.scene, self._controller, episode))
        self._closes = not opened
        if opened:
            self.gripper.open(self.scene.model, self._data)
        mujoco.mj_fwdPosition(self.scene.model, self._data)

    def step(self, action: np.ndarray) -> None:
        """One control frame on; ``action`` (action_size,) as in :meth:`pipeline.sim.worlds.Worlds.step`."""
        data, tip = self._data, self.tip[None]
        pose = TipPose(tip, data.xpos[self._hand][None].copy(), data.xquat[self._hand][None].copy())
        setpoint = next_setpoint(self.scene, tip, self._start, np.asarray(action, float)[None])
        self._write(self._controller.move(pose, setpoint))
        self.gripper.command(data, self._closes)
        mujoco.mj_step(self.scene.model, data, nstep=self.scene.params.substeps)
        mujoco.mj_fwdPosition(self.scene.model, data)

    def _write(self, fields: dict[str, np.ndarray]) -> None:
        for name, values in fields.items():
            field = getattr(self._data, name)
            field[:] = values[0].reshape(field.shape)

    def close(self) -> None:
        """The gripper closes from the next frame on."""
        self._closes = True

    def homeward(self) -> np.ndarray | None:
        """The action that leads back to the start, over obstacles; None where the tip is there."""
        state = State(self.tip[None], self.tip[None], self._start, self._start)
        way = (self._expert.waypoint(state)[0] - self.tip)[list(self.scene.axes)]
        if np.linalg.norm((self._start[0] - self.tip)[list(self.scene.axes)]) < _HOME_M:
            return None
        return np.asarray(np.clip(way / self.scene.params.displacement_m, -1.0, 1.0))

    def waypoint(self) -> np.ndarray:
        """Where one heads who knows all, shape (3,), m: the target, or first over an obstacle."""
        state = State(self.tip[None], self.tip[None], self.target[None], self.target[None])
        return np.asarray(self._expert.waypoint(state)[0])

    @property
    def tip(self) -> np.ndarray:
        """Shape (3,), m."""
        return np.array(self._data.site_xpos[self.scene.tip_site])

    @property
    def target(self) -> np.ndarray:
        """Shape (3,), m."""
        return np.array(self._data.mocap_pos[self.scene.target_mocap])

    @property
    def qpos(self) -> np.ndarray:
        """Generalised positions, shape (nq,)."""
        return np.array(self._data.qpos)

    @property
    def touches(self) -> bool:
        """Whether what lies between the fingers meets the target's marker, which itself has no contacts."""
        model, tip = self.scene.model, self.scene.tip_site
        apart = self.gripper.distance_m(model, self._data, tip, self.target)
        return apart <= self.scene.params.target.radius_m
