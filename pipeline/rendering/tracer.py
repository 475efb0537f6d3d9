"""The ray tracer of one viewpoint, on the device where it is made."""

from __future__ import annotations

import mujoco
import mujoco_warp as mjw
import numpy as np
import warp as wp

from pipeline.rendering import buffers, ray_packets, raytracer, shading


class Tracer:
    """What one camera sees of some geoms in many worlds; used by one thread at a time."""

    def __init__(
        self, model: mujoco.MjModel, geoms: np.ndarray, worlds: int, view: raytracer.View, rays: wp.array
    ) -> None:
        self._visible = wp.zeros(worlds, dtype=int)
        self.hits = raytracer.Hits()
        for name, kind in {"distance": float, "slot": int, "face": int, "u": float, "v": float}.items():
            setattr(self.hits, name, wp.zeros((worlds, rays.shape[1]), dtype=kind))
        self.subject = shading.Subject()
        self.subject.geoms, self._triangles, self.subject.corner_normals = buffers.geom_arrays(model, geoms)
        self.subject.placed = wp.zeros((worlds, len(geoms)), dtype=raytracer.Placed)
        self.subject.view, self.subject.rays = view, rays

    def trace(self, n: int, data: mjw.Data, limits: wp.array) -> None:
        """Traces the first ``n`` worlds as they stand, no farther than ``limits`` (rays,)."""
        subject = self.subject
        wp.launch(
            raytracer.survey,
            dim=n,
            inputs=[subject.geoms, data.geom_xpos, data.geom_xmat, subject.view],
            outputs=[subject.placed, self._visible],
        )
        side = -(-subject.view.samples // ray_packets.SIDE)
        wp.launch(
            raytracer.trace,
            dim=(n, side, side),
            inputs=[
                *(subject.geoms, self._triangles, subject.placed, self._visible),
                *(subject.view, subject.rays, limits),
            ],
            outputs=[self.hits],
        )


class StaticBackground:
    """What stands still: it looks the same in every world and picture.

    Attributes:
        distance: shape (rays,), m.
        rgb: shape (rays,) of three, 0 to 1.
        pixels: bytes (size, size, 3).
    """

    def __init__(self, tracer: Tracer, data: mjw.Data, background: wp.vec3, antialias: int) -> None:
        rays = tracer.subject.rays.shape[1]
        tracer.trace(1, data, wp.full(rays, raytracer.FAR_M, dtype=float))
        self.distance = tracer.hits.distance.flatten()
        self.rgb = wp.zeros(rays, dtype=wp.vec3)
        wp.launch(
            shading.shade_static,
            dim=rays,
            inputs=[tracer.hits, tracer.subject, background],
            outputs=[self.rgb],
        )
        size = tracer.subject.view.samples // antialias
        self.pixels = wp.zeros((size, size, 3), dtype=wp.uint8)
        wp.launch(
            shading.shade_static_pixels,
            dim=(size, size),
            inputs=[self.rgb, tracer.subject.view.samples, antialias],
            outputs=[self.pixels],
        )
