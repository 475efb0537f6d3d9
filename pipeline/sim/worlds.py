"""A batch of worlds: many episodes of one scene, stepped together."""

from __future__ import annotations

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from pipeline.contract.errors import BelvedereError
from pipeline.sim.arm_controllers import Fields, TipPose, arm_controller, next_setpoint
from pipeline.sim.draws import Episodes
from pipeline.sim.reward import reach_reward
from pipeline.sim.scene import Scene


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
        self._start = np.zeros((count, 3))
        self._target = np.zeros((count, 3))

    def reset(self, episodes: Episodes) -> None:
        """Starts one episode per world."""
        if len(episodes) != self.count:
            raise ValueError(f"{len(episodes)} episodes for {self.count} worlds")
        self._target = np.array(episodes.target_m, dtype=np.float64)
        self._start = np.array(episodes.start_m, dtype=np.float64)
        self._batch.reset(stage=mujoco.mjtStage.mjSTAGE_NONE)
        self._write(self._arm_controller.reset(self._start, self._target))
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
        self._batch.step(nstep=self.scene.params.substeps, stage=mujoco.mjtStage.mjSTAGE_POS)
        return reach_reward(self.tip, self._target)

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
        return self._target.copy()

    @property
    def qpos(self) -> np.ndarray:
        """Generalised positions, shape (count, nq), what a picture needs beside the target."""
        return self._qpos.astype(np.float32)


def not_a_number(scene: Scene) -> BelvedereError:
    """What to say of an action that is not a number."""
    return BelvedereError(
        f"scene {scene.name}: a policy gave an action that is not a number; its network or controller has "
        "diverged."
    )
