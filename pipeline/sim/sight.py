"""What a camera can see of tip and target, by geometry and ray casting with MuJoCo's own rays."""

from __future__ import annotations

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from pipeline.sim.camera import Viewpoint, camera_to_world
from pipeline.sim.scene import Scene

PICTURE_SIZE = 64  # pixels a side, as the world model sees it (paper II-C)
_DRAWN_BESIDE_TARGET = (0, 2)  # the target stands alone in group 1


def to_pixels(scene: Scene, view: Viewpoint, points_m: np.ndarray, size: int) -> np.ndarray:
    """Where points appear: shape (n, 3), m → (n, 2), column and row in pixels, 0 at the top left."""
    position, rotation = camera_to_world(scene.params.camera, view)
    inside = (points_m - position) @ rotation
    focal = size / 2 / np.tan(np.radians(scene.params.camera.fov_deg) / 2)
    return np.stack(
        [size / 2 + focal * inside[:, 0] / -inside[:, 2], size / 2 - focal * inside[:, 1] / -inside[:, 2]],
        axis=1,
    )


class Sight:
    """Counts, for a batch of states, the pixels in which the target is seen from a viewpoint.

    A ray is cast through the centre of every pixel near the target, as the ray tracer does.
    """

    def __init__(self, scene: Scene, count: int, threads: int = 1) -> None:
        self._scene, self._size = scene, PICTURE_SIZE
        self._batch = mujoco_batch.Batch(scene.model, count, threads)
        self._groups = np.zeros(mujoco.mjNGROUP, np.uint8)
        self._groups[list(_DRAWN_BESIDE_TARGET)] = 1

    def target_pixels(self, view: Viewpoint, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """Shapes (count, nq), (count, 3) → (count,)."""
        self._batch.bind("qpos")[:] = qpos
        origin, rotation = camera_to_world(self._scene.params.camera, view)
        rays = self._rays_about(view, target_m) @ rotation.T
        reach = _distance_to_sphere(origin, rays, target_m, self._scene.params.target.radius_m)
        hit, _ = self._batch.ray(origin, rays, geomgroup=self._groups)
        hidden = (hit >= 0) & (hit < reach)
        return np.asarray((np.isfinite(reach) & ~hidden).sum(axis=1), dtype=np.int32)

    def _rays_about(self, view: Viewpoint, target_m: np.ndarray) -> np.ndarray:
        """Unit rays (count, k², 3), camera frame, through the pixels that the target can cover."""
        camera, size = self._scene.params.camera, self._size
        slope = 2 * np.tan(np.radians(camera.fov_deg) / 2) / size
        near = camera.distance_m - self._farthest_m(target_m)
        half = int(np.ceil(1.2 * self._scene.params.target.radius_m / max(near, 0.1) / slope)) + 1
        middle = np.floor(to_pixels(self._scene, view, target_m, size))
        offsets = np.stack(np.meshgrid(*[np.arange(-half, half + 1)] * 2), axis=-1).reshape(-1, 2)
        pixels = middle[:, None] + offsets[None] + 0.5
        x, y = (pixels[..., 0] - size / 2) * slope, (size / 2 - pixels[..., 1]) * slope
        outside = ((pixels < 0) | (pixels > size)).any(axis=-1)
        rays = np.stack([x, y, -np.ones_like(x)], axis=-1)
        rays[outside] = [0.0, 0.0, 1.0]  # backwards: meets no target
        return rays / np.linalg.norm(rays, axis=-1, keepdims=True)

    def _farthest_m(self, target_m: np.ndarray) -> float:
        look_at = np.asarray(self._scene.params.camera.look_at_m)
        return float(np.linalg.norm(target_m - look_at, axis=1).max())


def _distance_to_sphere(
    origin: np.ndarray, rays: np.ndarray, center: np.ndarray, radius: float
) -> np.ndarray:
    """Along unit rays (n, k, 3) to spheres (n, 3): (n, k), infinity where a ray misses."""
    to_center = center - origin
    along = np.einsum("nkc,nc->nk", rays, to_center)
    miss_squared = np.sum(to_center**2, axis=1)[:, None] - along**2
    meets = (miss_squared < radius**2) & (along > 0)
    depth = np.sqrt(np.where(meets, radius**2 - miss_squared, 0.0))
    return np.where(meets, along - depth, np.inf)
