"""A scene's dm_control face, for single episodes.

Batches and single episodes share the model, the arm controller and the task, so they agree bit for bit.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from dm_control.mujoco import engine, wrapper
from dm_control.rl import control
from dm_env import specs

from pipeline.sim.arm_controllers import TipPose, arm_controller, next_setpoint
from pipeline.sim.draws import Episodes, draw_episodes
from pipeline.sim.scene import Scene
from pipeline.sim.worlds import start_fields, target_paths


class Physics(engine.Physics):
    """A scene's physics with the measurements that the task needs."""

    scene: Scene

    def tip(self) -> np.ndarray:
        """Tip position, shape (3,), m."""
        return np.array(self.data.site_xpos[self.scene.tip_site])

    def target(self) -> np.ndarray:
        """Target position, shape (3,), m."""
        return np.array(self.data.mocap_pos[self.scene.target_mocap])

    def point(self) -> np.ndarray:
        """The position of what shall come to the target, shape (3,), m."""
        return np.array(self.data.site_xpos[self.scene.point_site])

    def tip_pose(self) -> TipPose:
        """Where the hand is, with a leading axis of one world."""
        body = self.scene.model.site_bodyid[self.scene.tip_site]
        return TipPose(
            self.tip()[None], self.data.xpos[body][None].copy(), self.data.xquat[body][None].copy()
        )


class SceneTask(control.Task):
    """The scene's task: the action is a displacement of the tip on the controlled axes.

    Args:
        scene: the compiled scene.
        rng: draws episodes' starts and targets.
    """

    def __init__(self, scene: Scene, rng: np.random.Generator) -> None:
        self._scene, self._rng = scene, rng
        self._arm_controller = arm_controller(scene, 1, 1)
        self._start = np.zeros((1, 3))
        self._path, self._frame = np.zeros((1, 1, 3)), 0
        self._next: Episodes | None = None
        self._fresh: dict[str, np.ndarray] = {}

    def start_with(self, episode: Episodes) -> None:
        """The next episode begins as ``episode`` (of length 1) says, instead of as drawn."""
        self._next = episode

    def initialize_episode(self, physics: Physics) -> None:
        episode = self._next or draw_episodes(self._scene, 1, self._rng)
        self._next, self._start = None, episode.start_m
        self._path, self._frame = target_paths(self._scene, episode), 0
        self._fresh = start_fields(self._scene, self._arm_controller, episode)
        self._write(physics, self._fresh)

    def before_step(self, action: np.ndarray, physics: Physics) -> None:
        # dm_control ends a reset with a forward pass, which leaves its own guess for the solver
        self._write(physics, {name: self._fresh[name] for name in ("qacc_warmstart",) if self._fresh})
        self._fresh = {}
        tip_pose = physics.tip_pose()
        setpoint = next_setpoint(self._scene, tip_pose.tip_m, self._start, np.asarray(action)[None])
        self._write(physics, self._arm_controller.move(tip_pose, setpoint))
        self._frame = min(self._frame + 1, self._path.shape[1] - 1)
        physics.data.mocap_pos[self._scene.target_mocap] = self._path[0, self._frame]

    def after_step(self, physics: Physics) -> None:
        # mj_step leaves derived fields one substep behind the state
        mujoco.mj_fwdPosition(physics.model.ptr, physics.data.ptr)

    def action_spec(self, physics: Physics) -> specs.BoundedArray:
        return specs.BoundedArray((self._scene.action_size,), np.float64, -1.0, 1.0, name="displacement")

    def get_observation(self, physics: Physics) -> dict[str, np.ndarray]:
        return {"tip_m": physics.tip(), "target_m": physics.target()}

    def get_reward(self, physics: Physics) -> float:
        return -float(self._scene.task.error(physics.point()[None], physics.target()[None])[0])

    @staticmethod
    def _write(physics: Physics, fields: dict[str, np.ndarray]) -> None:
        for name, values in fields.items():
            field = getattr(physics.data, name)
            field[:] = values[0].reshape(field.shape)


def environment(scene: Scene, rng: np.random.Generator) -> control.Environment:
    """The scene as a dm_control environment: an episode has the scene's frames and never ends early."""
    physics = Physics.from_model(wrapper.MjModel(scene.model))
    physics.scene = scene
    frame_s = scene.params.substeps * scene.params.timestep_s
    settings: dict[str, Any] = {"n_sub_steps": scene.params.substeps, "legacy_step": False}
    limit_s = (scene.frames - 0.5) * frame_s  # dm_control counts frames in floats and rounds them up
    return control.Environment(physics, SceneTask(scene, rng), time_limit=limit_s, **settings)
