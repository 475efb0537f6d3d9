"""Pictures of one viewpoint by MuJoCo's own renderer, on an OpenGL context of EGL or, with a screen, GLFW."""

from __future__ import annotations

import importlib
from typing import Any

import mujoco
import numpy as np

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering.renderer import model_seen_from
from pipeline.sim.scene import CAMERA, Scene

_MOST_GEOMS = 2000
_LEFT_OUT = (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION)


class NoOpenGL(Exception):
    """There is no OpenGL here; its text says why."""


def _context(width: int, height: int) -> tuple[Any, str]:
    """An OpenGL context and its name."""
    reasons = []
    for kind in ("egl", "glfw"):
        try:
            context = importlib.import_module(f"mujoco.{kind}").GLContext(width, height)
            context.make_current()
            return context, f"mujoco-{kind}"
        except Exception as error:  # each library has errors of its own, some of them while it is imported
            reasons.append(f"{kind.upper()}: {' '.join(str(error).split()) or type(error).__name__}")
    raise NoOpenGL("; ".join(reasons))


class MujocoRenderer:
    """MuJoCo's renderer without shadows, as the scenes' light has none; for the thread that makes it only.

    Args:
        size: width and height, pixels.
        samples: a pixel; 0 is one.

    Raises:
        NoOpenGL: neither EGL nor GLFW gives a context.
    """

    def __init__(self, scene: Scene, view: Viewpoint, size: tuple[int, int], samples: int) -> None:
        self._context, self.name = _context(*size)
        self._model = model_seen_from(scene, view)
        self._model.vis.global_.offwidth, self._model.vis.global_.offheight = size
        self._model.vis.quality.offsamples = samples
        self._model.vis.quality.shadowsize = 0
        self._data = mujoco.MjData(self._model)
        mujoco.mj_forward(self._model, self._data)  # lights and camera
        self._target = scene.target_mocap
        self._scene = mujoco.MjvScene(self._model, maxgeom=_MOST_GEOMS)
        for flag in _LEFT_OUT:
            self._scene.flags[flag] = 0
        self._options, self._camera = mujoco.MjvOption(), mujoco.MjvCamera()
        self._camera.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._camera.fixedcamid = self._model.camera(CAMERA).id
        self._drawing = mujoco.MjrContext(self._model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._drawing)
        self._frame = mujoco.MjrRect(0, 0, *size)
        self._rgb = np.zeros((size[1], size[0], 3), np.uint8)

    def draw(self, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """A picture, uint8 (height, width, 3), of a world (nq,), (3,), m; the memory is used again."""
        self._context.make_current()
        self._data.qpos[:], self._data.mocap_pos[self._target] = qpos, target_m
        mujoco.mj_kinematics(self._model, self._data)
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(
            self._model, self._data, self._options, None, self._camera, everything, self._scene
        )
        mujoco.mjr_render(self._frame, self._scene, self._drawing)
        mujoco.mjr_readPixels(self._rgb, None, self._frame, self._drawing)
        return self._rgb[::-1]

    def close(self) -> None:
        """Frees the context, on the thread that made it."""
        self._context.make_current()
        self._drawing.free()
        self._context.free()
