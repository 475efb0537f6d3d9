"""A batch of worlds: many episodes of one scene, stepped together."""

from __future__ import annotations

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from pipeline.contract.errors import BelvedereError
from pipeline.sim.arm_controllers import ArmController, Fields, TipPose, arm_controller, next_setpoint
from pipeline.sim.draws import Episodes
from pipeline.sim.scene import Scene
from pipeline.sim.tasks.base import State


class Worlds:
    """``count`` worlds over one compiled model; results are bit-identical at any thread count.

    Args:
        scene: the compiled scene.
        count: how many worlds.
        threads: how many threads step them.
    """

    def __init__(self, scene: Scene, count: int, threads: int = 1) -> None:
        self.scene, self.count = scene, count
        self._batch = mujoco_batch.Batch(scene.model, count, threads)
        # bound before the first call: a field bound later is zero until the next one
        self._sites, self._places = self._batch.bind("site_xpos"), self._batch.bind("xpos")
        self._rotations, self._qpos = self._batch.bind("xquat"), self._batch.bind("qpos")
        self._hand_body = int(scene.model.site_bodyid[scene.tip_site])
        self._arm_controller = arm_controller(scene, count, threads)
        self._mocap = self._batch.bind("mocap_pos")
        self._start = np.zeros((count, 3))
        self._path, self._frame = np.zeros((count, 1, 3)), 0

    def reset(self, episodes: Episodes) -> None:
        """Starts one episode per world."""
        if len(episodes) != self.count:
            raise ValueError(f"{len(episodes)} episodes for {self.count} worlds")
        self._path, self._frame = target_paths(self.scene, episodes), 0
        self._start = np.array(episodes.start_m, dtype=np.float64)
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
        self._write(start_fields(self.scene, self._arm_controller, episodes))
        self._batch.forward(stage=mujoco.mjtStage.mjSTAGE_POS)

    def step(self, action: np.ndarray) -> np.ndarray:
        """Moves every world one frame on.

        Args:
            action: shape (count, action_size), shares of the largest displacement in [-1, 1].

        Returns:
            The rewards, paper eq. (1): shape (count,), m.

        Raises:
            BelvedereError: an action is not a number.
        """
        if not np.isfinite(action).all():
            raise not_a_number(self.scene)
        tip_pose = TipPose(self.tip, self._places[:, self._hand_body], self._rotations[:, self._hand_body])
        setpoint = next_setpoint(self.scene, tip_pose.tip_m, self._start, action)
        self._write(self._arm_controller.move(tip_pose, setpoint))
        self._frame += 1
        self._mocap[:, self.scene.target_mocap] = self._at(self._frame)
        self._batch.step(nstep=self.scene.params.substeps, stage=mujoco.mjtStage.mjSTAGE_POS)
        return -self.error

    def _write(self, fields: Fields) -> None:
        for name, values in fields.items():
            self._batch.bind(name)[:] = values.reshape(self._batch.bind(name).shape)

    @property
    def tip(self) -> np.ndarray:
        """Tip positions, shape (count, 3), m."""
        return np.array(self._sites[:, self.scene.tip_site])

    @property
    def target(self) -> np.ndarray:
        """Target positions, shape (count, 3), m."""
        return self._at(self._frame).copy()

    @property
    def point(self) -> np.ndarray:
        """What shall come to the targets, the tip or another body: shape (count, 3), m."""
        return np.array(self._sites[:, self.scene.point_site])

    @property
    def error(self) -> np.ndarray:
        """The distances that the rewards count, shape (count,), m."""
        return self.scene.task.error(self.point, self._at(self._frame))

    @property
    def state(self) -> State:
        """What an expert is told."""
        return State(self.tip, self.point, self.target, self._at(self._frame + 1).copy())

    def _at(self, frame: int) -> np.ndarray:
        """The targets after so many frames; after the last one they rest."""
        return self._path[:, min(frame, self._path.shape[1] - 1)]

    @property
    def qpos(self) -> np.ndarray:
        """Generalised positions, shape (count, nq), what a picture needs beside the target."""
        return self._qpos.astype(np.float32)


def target_paths(scene: Scene, episodes: Episodes) -> np.ndarray:
    """Where the targets of n episodes are at the start and after each of t frames: (n, t + 1, 3), m."""
    target_m = np.array(episodes.target_m, dtype=np.float64)
    return scene.task.targets(scene.params, target_m, episodes.drawn)


def start_fields(scene: Scene, controller: ArmController, episodes: Episodes) -> Fields:
    """The state in which each episode starts: of the robot, of the target and of what the task brings."""
    fields = controller.reset(np.array(episodes.start_m), target_paths(scene, episodes)[:, 0])
    scene.task.begin(scene.model, fields, episodes.drawn)
    return fields


def not_a_number(scene: Scene) -> BelvedereError:
    """What to say of an action that is not a number."""
    return BelvedereError(
        f"scene {scene.name}: a policy gave an action that is not a number; its network or controller has "
        "diverged."
    )
