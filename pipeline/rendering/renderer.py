"""Ray-traced pictures of a batch of worlds from one viewpoint (Warp; needs no OpenGL).

mujoco_warp poses the geoms; :mod:`pipeline.rendering.raytracer` and :mod:`pipeline.rendering.shading` draw
them.
"""

from __future__ import annotations

import copy
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering import buffers, shading
from pipeline.rendering.tracer import StaticBackground, Tracer
from pipeline.rendering.visibility import PICTURE_SIZE
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import CAMERA, Scene, initial_data
from pipeline.sim.tasks.bodies import TARGET_GROUP
from pipeline.storage.parts import places

VISIBLE_GROUPS = (0, 1, 2)
_NO_GEOMS = range(-2, -2)
_SHARD = 32  # worlds a call; small enough to share out evenly, large enough to fill a core


def start_ray_tracer() -> None:
    """Starts Warp quietly.

    Raises:
        BelvedereError: its kernel cache cannot be written to.
    """
    wp.config.log_level = wp.LOG_ERROR
    try:
        wp.init()
        folder = wp.config.kernel_cache_dir
        os.makedirs(folder, exist_ok=True)
        if not os.access(folder, os.W_OK):
            raise PermissionError(13, "Permission denied", folder)
    except OSError as error:
        raise BelvedereError(
            f"Warp's kernel cache {error.filename or wp.config.kernel_cache_dir} cannot be written to; make "
            "it writable or set WARP_CACHE_PATH to a folder that is."
        ) from None


def model_seen_from(scene: Scene, view: Viewpoint) -> mujoco.MjModel:
    """A copy of the scene's model with its camera at a viewpoint."""
    model = copy.copy(scene.model)
    camera = model.camera(CAMERA).id
    position, rotation = camera_to_world(scene.params.camera, view)
    model.cam_pos[camera] = position
    mujoco.mju_mat2Quat(model.cam_quat[camera], rotation.reshape(-1))
    return model


def warp_model(scene: Scene, model: mujoco.MjModel) -> mjw.Model:
    """The model on Warp's current device.

    Raises:
        BelvedereError: MuJoCo Warp lacks something that the model has.
    """
    try:
        return mjw.put_model(model)
    except NotImplementedError as error:
        raise BelvedereError(
            f"scene {scene.name}: MuJoCo Warp, which poses what is drawn, lacks something of robot "
            f"{scene.robot.name} ({scene.declared.file}): {' '.join(str(error).split())}."
        ) from None


class Renderer:
    """Pictures of ``count`` worlds; used by one thread at a time (it releases the GIL).

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        count: how many worlds a call draws at most.
        size: side of the square picture, pixels.
        antialias: rays per pixel and side.
        groups: the geom groups that are drawn.
        segment: whether :meth:`target_pixels` is wanted.
        device: where Warp draws.

    Raises:
        BelvedereError: the scene holds a geom or light that cannot be drawn.
    """

    def __init__(
        self,
        scene: Scene,
        view: Viewpoint,
        count: int,
        size: int = PICTURE_SIZE,
        antialias: int = 1,
        groups: tuple[int, ...] = VISIBLE_GROUPS,
        segment: bool = False,
        device: wp.DeviceLike = "cpu",
    ) -> None:
        start_ray_tracer()
        self._device = wp.get_device(device)
        model = model_seen_from(scene, view)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        self._scene, self._antialias = scene, antialias
        counted = scene.target_geoms if segment else _NO_GEOMS
        self._target = wp.vec2i(counted.start, counted.stop)
        geoms = buffers.visible_geoms(model, groups)
        still = buffers.static_geoms(model, geoms)
        samples, camera = size * antialias, model.camera(CAMERA).id
        with wp.ScopedDevice(self._device):
            self._model = warp_model(scene, model)
            self._data = mjw.make_data(model, nworld=count, nconmax=1, njmax=1)
            initial = np.tile(initial_data(scene).qpos.astype(np.float32), (count, 1))
            self._data.qpos.assign(initial)  # where locked joints stand
            mjw.kinematics(self._model, self._data)
            eye, rays = buffers.view_of(model, data, camera, samples)
            lights = buffers.lights_of(model, data, camera)
            fixed = Tracer(model, geoms[still], 1, eye, rays)
            self._tracer = Tracer(model, geoms[~still], count, eye, rays)
            fixed.subject.lights = self._tracer.subject.lights = lights
            self._background = StaticBackground(
                fixed, self._data, wp.vec3(*scene.params.light.background_rgb), antialias
            )
            self._rgb = wp.zeros((count, size, size, 3), dtype=wp.uint8)
            self._seen = wp.zeros(count, dtype=int)

    def render(self, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """Draws the worlds.

        Args:
            qpos: generalised positions, shape (n, nq), n at most ``count``.
            target_m: target positions, shape (n, 3), m.

        Returns:
            uint8 pictures, shape (n, size, size, 3); the memory is used again by the next call.
        """
        n = len(qpos)
        targets = self._data.mocap_pos[:n, self._scene.target_mocap]
        with wp.ScopedDevice(self._device):
            for array, values in ((self._data.qpos[:n], qpos), (targets, target_m)):
                wp.copy(array, wp.array(values, dtype=array.dtype))
            mjw.kinematics(self._model, self._data)
        return self.draw(self._data, n).numpy()[:n]

    def draw(self, data: mjw.Data, n: int) -> wp.array:
        """Draws the first ``n`` worlds of ``data``, on this device, as their geoms stand; copies nothing.

        Returns:
            uint8 pictures, shape (count, size, size, 3); the memory is used again by the next call.
        """
        with wp.ScopedDevice(self._device):
            self._tracer.trace(n, data, self._background.distance)
            self._seen.zero_()
            wp.launch(
                shading.shade,
                dim=(n, self._rgb.shape[1]),
                inputs=[
                    *(self._tracer.hits, self._tracer.subject, self._background.rgb, self._background.pixels),
                    *(self._antialias, self._target),
                ],
                outputs=[self._rgb, self._seen],
            )
        return self._rgb

    def target_pixels(self, count: int) -> np.ndarray:
        """In how many pixels of the last pictures the target is seen; shape (count,)."""
        return self._seen.numpy()[:count] // self._antialias**2


class ParallelRenderer:
    """Pictures of any number of worlds, on all cores: for what is rendered outside the closed loop."""

    def __init__(self, scene: Scene, view: Viewpoint, threads: int, segment: bool = False) -> None:
        self.scene, self.view = scene, view
        self._workers = [Renderer(scene, view, _SHARD, segment=segment) for _ in range(threads)]
        self._free = list(self._workers)
        self._pool = ThreadPoolExecutor(threads)
        self._segment = segment

    def render(
        self, qpos: np.ndarray, target_m: np.ndarray, drawn: Callable[[int], None]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draws worlds (n, nq), (n, 3): pictures (n, 64, 64, 3) and pixels of the target (n,).

        ``drawn`` is told, from any thread, how many more pictures are done.
        """
        n = len(qpos)
        rgb = np.empty((n, PICTURE_SIZE, PICTURE_SIZE, 3), np.uint8)
        pixels = np.zeros(n, np.int32)

        def draw(part: slice) -> None:
            worker = self._free.pop()
            rgb[part] = worker.render(qpos[part], target_m[part])
            if self._segment:
                pixels[part] = worker.target_pixels(part.stop - part.start)
            self._free.append(worker)
            drawn(part.stop - part.start)

        list(self._pool.map(draw, places(n, _SHARD)))
        return rgb, pixels


def target_pixels_unhidden(
    scene: Scene, view: Viewpoint, qpos: np.ndarray, target_m: np.ndarray
) -> np.ndarray:
    """Pixels of the target, were nothing in front of it: shapes (n, nq), (n, 3) → (n,)."""
    images = Renderer(scene, view, min(len(qpos), _SHARD), groups=(TARGET_GROUP,), segment=True)
    pixels = np.zeros(len(qpos), np.int32)
    for place in places(len(qpos), _SHARD):
        images.render(qpos[place], target_m[place])
        pixels[place] = images.target_pixels(place.stop - place.start)
    return pixels
