"""Pictures: Belvedere's ray tracer against MuJoCo's own renderer, both on one core, in frames a second."""

from __future__ import annotations

import os
import statistics
import time

import mujoco
import numpy as np

from benchmarks.rows import Row, goal_row
from pipeline.contract import params
from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import Renderer, model_seen_from
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.draws import draw_episodes
from pipeline.sim.scene import CAMERA, Scene, load_scene
from pipeline.sim.worlds import Worlds

GOAL = 8.0
WORLDS, STEPS, ROUNDS = 32, 12, 7
_LEFT_OUT = (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION)


def measure() -> list[Row]:
    """One row per scene, at its first candidate view."""
    os.environ.setdefault("LP_NUM_THREADS", "0")  # Mesa draws on the thread that asks, so its time counts
    views = [Viewpoint(**view) for view in params.value("viewpoints").values()]
    first = {view.scene: view for view in reversed(views)}
    return [measure_view(load_scene(name), first[name]) for name in params.value("scenes") if name in first]


def measure_view(scene: Scene, view: Viewpoint) -> Row:
    """The row of one view: medians over rounds in which both draw the same states in turn."""
    qpos, target_m = states(scene)
    images, stripped = Renderer(scene, view, WORLDS), Stripped(scene, view)
    images.render(qpos, target_m)  # the first call compiles
    stripped.render(qpos, target_m)
    ours, peer = [], []
    for _ in range(ROUNDS):
        begin = time.thread_time()
        images.render(qpos, target_m)
        middle = time.thread_time()
        stripped.render(qpos, target_m)
        end = time.thread_time()
        ours.append(WORLDS / (middle - begin))
        peer.append(WORLDS / (end - middle))
    stripped.close()
    ratio = statistics.median(mine / other for mine, other in zip(ours, peer, strict=True))
    rates = statistics.median(ours), statistics.median(peer)
    return goal_row("pictures of 64 × 64, one core", scene.name, *rates, "frames/s", ratio, GOAL)


def states(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Generalised positions and targets of random rollouts, some steps in."""
    rng = np.random.default_rng(1)
    worlds = Worlds(scene, WORLDS)
    worlds.reset(draw_episodes(scene, WORLDS, rng))
    direction = rng.uniform(-1, 1, (WORLDS, scene.action_size))
    for _ in range(STEPS):
        worlds.step(direction)
    return worlds.qpos, worlds.target


def stripped_renderer(model: mujoco.MjModel) -> mujoco.Renderer:
    """MuJoCo's renderer of 64 × 64 pictures without shadows, reflections, multisampling; alters the model."""
    model.vis.quality.offsamples = model.vis.quality.shadowsize = 0
    renderer = mujoco.Renderer(model, PICTURE_SIZE, PICTURE_SIZE)
    for flag in _LEFT_OUT:
        renderer.scene.flags[flag] = 0
    return renderer


class Stripped:
    """MuJoCo's renderer with all that costs and that the ray tracer leaves out switched off."""

    def __init__(self, scene: Scene, view: Viewpoint) -> None:
        self._mocap = scene.target_mocap
        self._model = model_seen_from(scene, view)
        self._data = mujoco.MjData(self._model)
        self._renderer = stripped_renderer(self._model)

    def render(self, qpos: np.ndarray, target_m: np.ndarray) -> None:
        """Draws the worlds one by one."""
        mujoco.mj_forward(self._model, self._data)  # lights and camera
        for q, target in zip(qpos, target_m, strict=True):
            self._data.qpos, self._data.mocap_pos[self._mocap] = q, target
            mujoco.mj_kinematics(self._model, self._data)
            self._renderer.update_scene(self._data, CAMERA)
            self._renderer.render()

    def close(self) -> None:
        """Frees the renderer, and its OpenGL context, on this thread."""
        self._renderer.close()
