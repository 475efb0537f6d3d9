"""Ray-traced pictures of any width and height, in bands that are drawn side by side.

The pipeline's renderer draws square pictures. A band is one of these, cut down to its rows: the camera's lens
is shifted, as in architectural photography, so that the band's first row is the square's first row, and only
the rows of the band are traced and shaded. Pixels of all bands together are those of one picture; focal
length and so the vertical field of view are those of MuJoCo's renderer at this height.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

from pipeline.contract.viewpoints import Viewpoint
from pipeline.rendering import buffers, raytracer, shading
from pipeline.rendering.ray_packets import SIDE
from pipeline.rendering.renderer import VISIBLE_GROUPS, model_seen_from, start_ray_tracer, warp_model
from pipeline.sim.scene import CAMERA, Scene, initial_data
from pipeline.station.lens import band_view

_NO_TARGET = (-2, -2)


class Shapes:
    """What is drawn of a scene, on the CPU: the same for all bands and views.

    Attributes:
        model: for poses.
        still, moving: geoms, triangles and corner normals of what stands still and of what moves.
    """

    def __init__(self, scene: Scene) -> None:
        start_ray_tracer()
        geoms = buffers.visible_geoms(scene.model, VISIBLE_GROUPS)
        stands = buffers.static_geoms(scene.model, geoms)
        with wp.ScopedDevice("cpu"):
            self.model = warp_model(scene, scene.model)
            self.still = buffers.geom_arrays(scene.model, geoms[stands])
            self.moving = buffers.geom_arrays(scene.model, geoms[~stands])


@lru_cache(maxsize=8)
def shapes_of(scene: Scene) -> Shapes:
    """The scene's shapes, made once."""
    return Shapes(scene)


class Layer:
    """What the rays of a band hit of some geoms."""

    def __init__(
        self,
        shapes: tuple[wp.array, wp.array, wp.array],
        view: raytracer.View,
        rays: wp.array,
        lights: wp.array,
    ) -> None:
        self.hits, self.subject = raytracer.Hits(), shading.Subject()
        for name, kind in {"distance": float, "slot": int, "face": int, "u": float, "v": float}.items():
            setattr(self.hits, name, wp.zeros((1, rays.shape[1]), dtype=kind))
        self.subject.geoms, self._triangles, self.subject.corner_normals = shapes
        self.subject.placed = wp.zeros((1, shapes[0].shape[0]), dtype=raytracer.Placed)
        self.subject.view, self.subject.rays, self.subject.lights = view, rays, lights
        self._visible = wp.zeros(1, dtype=int)

    def trace(self, data: mjw.Data, packets: tuple[int, int, int], limits: wp.array) -> None:
        """Traces so many packets (1, down, across), no farther than ``limits`` (rays,)."""
        subject = self.subject
        wp.launch(
            raytracer.survey,
            dim=1,
            inputs=[subject.geoms, data.geom_xpos, data.geom_xmat, subject.view],
            outputs=[subject.placed, self._visible],
        )
        wp.launch(
            raytracer.trace,
            dim=packets,
            inputs=[
                *(subject.geoms, self._triangles, subject.placed, self._visible),
                *(subject.view, subject.rays, limits),
            ],
            outputs=[self.hits],
        )


class Band:
    """Some rows of a picture.

    Args:
        shapes: of the scene.
        model, posed: with the camera in place.
        data: the scene at rest, for what stands still.
        background: colour, each channel 0 to 1.
        size: width and height of the whole picture, pixels.
        first: the band's first row.
        rows: how many it has.
    """

    def __init__(
        self,
        shapes: Shapes,
        model: mujoco.MjModel,
        posed: mujoco.MjData,
        data: mjw.Data,
        background: tuple[float, float, float],
        size: tuple[int, int],
        first: int,
        rows: int,
    ) -> None:
        camera = model.camera(CAMERA).id
        eye, rays = band_view(model, posed, camera, size, first, rows)
        lights = buffers.lights_of(model, posed, camera)
        self._packets = 1, rows // SIDE, size[0] // SIDE
        self._moving = Layer(shapes.moving, eye, rays, lights)
        self._rgb = wp.zeros((1, rows, size[0], 3), dtype=wp.uint8)
        self._seen = wp.zeros(1, dtype=int)
        self._draw_still(Layer(shapes.still, eye, rays, lights), data, wp.vec3(*background))

    def _draw_still(self, still: Layer, data: mjw.Data, background: wp.vec3) -> None:
        rays = still.subject.rays.shape[1]
        still.trace(data, self._packets, wp.full(rays, raytracer.FAR_M, dtype=float))
        self._limits = still.hits.distance.flatten()
        self._still_rgb = wp.zeros(rays, dtype=wp.vec3)
        wp.launch(
            shading.shade_static,
            dim=rays,
            inputs=[still.hits, still.subject, background],
            outputs=[self._still_rgb],
        )
        shape = self._rgb.shape[1:]
        self._still = wp.zeros(shape, dtype=wp.uint8)
        wp.launch(
            shading.shade_static_pixels,
            dim=shape[:2],
            inputs=[self._still_rgb, still.subject.view.samples, 1],
            outputs=[self._still],
        )

    def draw(self, data: mjw.Data) -> np.ndarray:
        """The rows, uint8 (rows, width, 3), as the geoms of ``data`` stand; the memory is used again."""
        with wp.ScopedDevice("cpu"):
            self._moving.trace(data, self._packets, self._limits)
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
        size: width and height, pixels, multiples of 4.
        threads: bands that are drawn side by side.
    """

    name = "ray tracer"

    def __init__(self, scene: Scene, view: Viewpoint, size: tuple[int, int], threads: int) -> None:
        self._shapes, self._target = shapes_of(scene), scene.target_mocap
        model = model_seen_from(scene, view)
        posed = mujoco.MjData(model)
        mujoco.mj_forward(model, posed)
        height = size[1]
        # more bands than threads: where the robot is, rows take longer
        rows = max(SIDE, -(-height // (4 * threads) // SIDE) * SIDE) if threads > 1 else height
        with wp.ScopedDevice("cpu"):
            self._data = mjw.make_data(scene.model, nworld=1, nconmax=1, njmax=1)
            self._data.qpos.assign(initial_data(scene).qpos.astype(np.float32)[None])
            mjw.kinematics(self._shapes.model, self._data)
            shared = self._shapes, model, posed, self._data, scene.params.light.background_rgb, size
            self._bands = [
                Band(*shared, first, min(rows, height - first)) for first in range(0, height, rows)
            ]
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="ray tracer")

    def draw(self, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """A picture, uint8 (height, width, 3), of a world (nq,), (3,), m."""
        with wp.ScopedDevice("cpu"):
            self._data.qpos.assign(qpos.astype(np.float32)[None])
            self._data.mocap_pos.numpy()[0, self._target] = target_m  # shares its memory on the CPU
            mjw.kinematics(self._shapes.model, self._data)
        return np.concatenate(list(self._pool.map(lambda band: band.draw(self._data), self._bands)))

    def close(self) -> None:
        """Ends its threads."""
        self._pool.shutdown()
