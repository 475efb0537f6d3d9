"""Ray-traced pictures of any width and height, in bands that are drawn side by side.

The pipeline's renderer draws square pictures. A band is one of these, cut down to its rows: the camera's lens
is shifted, as in architectural photography, so that the band's first row is the square's first row, and only
the rows of the band are traced and shaded. Pixels of all bands together are those of one picture; focal
length and so the vertical field of view are those of MuJoCo's renderer at this height.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering import buffers, raytracer, shading
from pipeline.rendering.ray_packets import SIDE
from pipeline.rendering.renderer import VISIBLE_GROUPS, model_seen_from, start_ray_tracer, warp_model
from pipeline.rendering.tracer import Tracer
from pipeline.sim.scene import CAMERA, Scene, initial_data

_NO_TARGET = (-2, -2)


def band_view(
    model: mujoco.MjModel, data: mujoco.MjData, camera: int, size: tuple[int, int], first: int, rows: int
) -> tuple[raytracer.View, wp.array]:
    """A square view whose first ``rows`` rows are those from ``first`` on of a picture, and its rays.

    Args:
        size: width and height of the picture, pixels; the width is a multiple of 4, as are the rows.

    Returns:
        The view, and the rays of its rows (3, r), world frame, packet by packet, padded to the whole square.
    """
    width, height = size
    rotation = data.cam_xmat[camera].reshape(3, 3)
    focal = height / 2 / np.tan(np.radians(model.cam_fovy[camera]) / 2)
    across = (np.arange(width) + 0.5 - width / 2) / focal
    down = (np.arange(rows) + first + 0.5 - height / 2) / focal
    rays = np.stack(np.broadcast_arrays(across, -down[:, None], -1.0), axis=-1) @ rotation.T
    rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
    blocks = rays.reshape(rows // SIDE, SIDE, width // SIDE, SIDE, 3)
    view, _ = buffers.view_of(model, data, camera, SIDE)  # origin and light
    # what the camera sees in direction (x, y, z) is to be found `shift` rows lower in the square, in whose
    # middle row width / 2 rows are above it: y is sheared along z
    shift = (height / 2 - first) - width / 2
    sheared = rotation @ np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, shift / focal, 1.0]])
    view.rotation, view.focal, view.samples = wp.mat33(*sheared.reshape(-1)), focal, width
    return view, wp.array(blocks.transpose(4, 0, 2, 1, 3).reshape(3, -1), dtype=float)


class Band:
    """Some rows of a picture.

    Args:
        scene: the compiled scene.
        view: where the camera stands.
        size: width and height of the whole picture, pixels.
        first: the band's first row.
        rows: how many it has.
    """

    def __init__(self, scene: Scene, view: Viewpoint, size: tuple[int, int], first: int, rows: int) -> None:
        model = model_seen_from(scene, view)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        camera, self._target_mocap = model.camera(CAMERA).id, scene.target_mocap
        self._dim = (1, rows // SIDE, size[0] // SIDE)
        geoms = buffers.visible_geoms(model, VISIBLE_GROUPS)
        still = buffers.static_geoms(model, geoms)
        with wp.ScopedDevice("cpu"):
            self._model = warp_model(scene, model)
            self._data = mjw.make_data(model, nworld=1, nconmax=1, njmax=1)
            self._data.qpos.assign(initial_data(scene).qpos.astype(np.float32)[None])
            mjw.kinematics(self._model, self._data)
            eye, rays = band_view(model, data, camera, size, first, rows)
            lights = buffers.lights_of(model, data, camera)
            fixed = Tracer(model, geoms[still], 1, eye, rays)
            self._moving = Tracer(model, geoms[~still], 1, eye, rays)
            fixed.subject.lights = self._moving.subject.lights = lights
            self._rgb = wp.zeros((1, rows, size[0], 3), dtype=wp.uint8)
            self._draw_still(fixed, wp.vec3(*scene.params.light.background_rgb))
            self._seen = wp.zeros(1, dtype=int)

    def _draw_still(self, fixed: Tracer, background: wp.vec3) -> None:
        rays = fixed.subject.rays.shape[1]
        self._trace(fixed, wp.full(rays, raytracer.FAR_M, dtype=float))
        self._limits = fixed.hits.distance.flatten()
        self._still_rgb = wp.zeros(rays, dtype=wp.vec3)
        wp.launch(
            shading.shade_static,
            dim=rays,
            inputs=[fixed.hits, fixed.subject, background],
            outputs=[self._still_rgb],
        )
        shape = self._rgb.shape[1:]
        self._still = wp.zeros(shape, dtype=wp.uint8)
        wp.launch(
            shading.shade_static_pixels,
            dim=shape[:2],
            inputs=[self._still_rgb, fixed.subject.view.samples, 1],
            outputs=[self._still],
        )

    def _trace(self, tracer: Tracer, limits: wp.array) -> None:
        subject = tracer.subject
        wp.launch(
            raytracer.survey,
            dim=1,
            inputs=[subject.geoms, self._data.geom_xpos, self._data.geom_xmat, subject.view],
            outputs=[subject.placed, tracer._visible],
        )
        wp.launch(
            raytracer.trace,
            dim=self._dim,
            inputs=[
                *(subject.geoms, tracer._triangles, subject.placed, tracer._visible),
                *(subject.view, subject.rays, limits),
            ],
            outputs=[tracer.hits],
        )

    def draw(self, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """The rows, uint8 (rows, width, 3), of a world (nq,), (3,), m; the memory is used again."""
        with wp.ScopedDevice("cpu"):
            self._data.qpos.assign(qpos.astype(np.float32)[None])
            places = self._data.mocap_pos.numpy()  # shares its memory on the CPU
            places[0, self._target_mocap] = target_m
            mjw.kinematics(self._model, self._data)
            self._trace(self._moving, self._limits)
            wp.launch(
                shading.shade,
                dim=(1, self._rgb.shape[1]),
                inputs=[
                    *(self._moving.hits, self._moving.subject, self._still_rgb, self._still),
                    *(1, wp.vec2i(*_NO_TARGET)),
                ],
                outputs=[self._rgb, self._seen],
            )
        return np.asarray(self._rgb.numpy()[0])


class RayTracer:
    """Pictures of one viewpoint by the pipeline's ray tracer, on some cores.

    Args:
        size: width and height, pixels, multiples of 16.
        threads: bands that are drawn side by side.
    """

    name = "ray tracer"

    def __init__(self, scene: Scene, view: Viewpoint, size: tuple[int, int], threads: int) -> None:
        start_ray_tracer()
        height = size[1]
        # more bands than threads: where the robot is, rows take longer
        rows = max(SIDE, -(-height // (4 * threads) // SIDE) * SIDE) if threads > 1 else height
        self._bands = [
            Band(scene, view, size, first, min(rows, height - first)) for first in range(0, height, rows)
        ]
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="ray tracer")

    def draw(self, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """A picture, uint8 (height, width, 3), of a world (nq,), (3,), m."""
        return np.concatenate(list(self._pool.map(lambda band: band.draw(qpos, target_m), self._bands)))

    def close(self) -> None:
        """Ends its threads."""
        self._pool.shutdown()
