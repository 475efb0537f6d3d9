"""What a camera can see of tip and target, by geometry and ray casting with MuJoCo's own rays."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco import batch as mujoco_batch

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.boxes import crosses
from pipeline.sim.camera import camera_to_world
from pipeline.sim.scene import Scene
from pipeline.sim.tasks.bodies import TARGET_GROUP

PICTURE_SIZE = 64  # pixels a side, as the world model sees it (paper II-C)
_DRAWN = (0, 1, 2)  # geom groups


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
        self._scene = scene
        self._batch = mujoco_batch.Batch(scene.model, count, threads)
        self._groups = np.zeros(mujoco.mjNGROUP, np.uint8)
        self._groups[list(_DRAWN)] = 1

    def target_pixels(self, view: Viewpoint, qpos: np.ndarray, target_m: np.ndarray) -> np.ndarray:
        """Shapes (count, nq), (count, 3) → (count,)."""
        self._batch.bind("qpos")[:] = qpos
        self._batch.bind("mocap_pos")[:, self._scene.target_mocap] = target_m
        origin, rotation = camera_to_world(self._scene.params.camera, view)
        rays = _rays_about(self._scene, view, target_m) @ rotation.T
        _, geom = self._batch.ray(origin, rays, geomgroup=self._groups)
        mine = (geom >= self._scene.target_geoms.start) & (geom < self._scene.target_geoms.stop)
        return np.asarray(mine.sum(axis=1), dtype=np.int32)


def refuse_hidden_targets(scene: Scene, view: Viewpoint) -> None:
    """Holds a viewpoint to the paper's rule for obstacles: they may hide no target position wholly.

    Counted are the pixels in which a target at one of the scene's candidate positions (without jitter)
    is seen past all that is fixed in the scene: obstacles, desk and table, but not the robot.

    Raises:
        BelvedereError: there are none.
    """
    targets = np.asarray(scene.params.target.candidates_m)
    origin, rotation = camera_to_world(scene.params.camera, view)
    rays = _rays_about(scene, view, targets) @ rotation.T
    reach = _distance_to_target(scene, origin, rays, targets)
    for target, its_rays, its_reach in zip(targets, rays, reach, strict=True):
        in_picture = np.isfinite(its_reach)
        ends = origin + its_rays[in_picture] * its_reach[in_picture, None]
        hides = {name: box.crossed(origin, ends) for name, box in _solids(scene).items()}
        if not np.any(list(hides.values()), axis=0).all() and in_picture.any():
            continue
        hiders = " and ".join(name for name, hidden in hides.items() if hidden.any())
        fault = f"{hiders} hides" if in_picture.any() else "the picture's edge cuts off"
        raise BelvedereError(
            f"scene {scene.name}: from viewpoint ({view.theta:g}°, {view.phi:g}°) {fault} the whole target "
            f"at {target.tolist()} m; take another viewpoint, or in params.yaml move the obstacles, "
            f"target.candidates_m or camera of scenes.{scene.name}."
        )


@dataclass(frozen=True, eq=False)
class _Solid:
    """A box: where its middle is and how it is turned, (3,) and (3, 3), and half its size, m."""

    middle: np.ndarray
    rotation: np.ndarray
    half_size: np.ndarray

    def crossed(self, origin: np.ndarray, ends: np.ndarray) -> np.ndarray:
        """Whether segments from a point (3,) to points (n, 3) pass through it: (n,)."""
        begin, end = (origin - self.middle) @ self.rotation, (ends - self.middle) @ self.rotation
        return crosses(np.broadcast_to(begin, end.shape), end, -self.half_size, self.half_size)


def _solids(scene: Scene) -> dict[str, _Solid]:
    """The scene's boxes that are no part of the robot or the target, by name."""
    model, found = scene.model, {}
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for geom in np.flatnonzero(model.geom_type == mujoco.mjtGeom.mjGEOM_BOX):
        if geom in scene.target_geoms:
            continue
        body = model.body(model.geom_bodyid[geom]).name
        if not body.startswith(scene.robot.prefix):
            rotation = data.geom_xmat[geom].reshape(3, 3)
            solid = _Solid(data.geom_xpos[geom].copy(), rotation.copy(), model.geom_size[geom].copy())
            found[model.geom(geom).name or body] = solid
    return found


def _rays_about(scene: Scene, view: Viewpoint, target_m: np.ndarray) -> np.ndarray:
    """Unit rays (n, k², 3), camera frame, through the pixels that targets at (n, 3), m, can cover."""
    camera, size = scene.params.camera, PICTURE_SIZE
    slope = 2 * np.tan(np.radians(camera.fov_deg) / 2) / size
    near = camera.distance_m - np.linalg.norm(target_m - np.asarray(camera.look_at_m), axis=1).max()
    half = int(np.ceil(1.2 * scene.task.extent_m(scene.params) / max(near, 0.1) / slope)) + 1
    middle = np.floor(to_pixels(scene, view, target_m, size))
    offsets = np.stack(np.meshgrid(*[np.arange(-half, half + 1)] * 2), axis=-1).reshape(-1, 2)
    pixels = middle[:, None] + offsets[None] + 0.5
    x, y = (pixels[..., 0] - size / 2) * slope, (size / 2 - pixels[..., 1]) * slope
    outside = ((pixels < 0) | (pixels > size)).any(axis=-1)
    rays = np.stack([x, y, -np.ones_like(x)], axis=-1)
    rays[outside] = [0.0, 0.0, 1.0]  # backwards: hits no target
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def _distance_to_target(
    scene: Scene, origin: np.ndarray, rays: np.ndarray, target_m: np.ndarray
) -> np.ndarray:
    """Along unit rays (n, k, 3) to targets at (n, 3): (n, k), infinity where a ray misses."""
    data, groups = mujoco.MjData(scene.model), np.zeros(mujoco.mjNGROUP, np.uint8)
    groups[TARGET_GROUP] = 1
    found = np.full(rays.shape[:2], np.inf)
    for place_m, its_rays, distance in zip(target_m, rays, found, strict=True):
        data.mocap_pos[scene.target_mocap] = place_m
        mujoco.mj_kinematics(scene.model, data)
        count, along = len(its_rays), np.zeros(len(its_rays))
        geom, flat = np.zeros(count, np.int32), its_rays.reshape(-1, 1)
        mujoco.mj_multiRay(
            scene.model, data, origin, flat, groups, True, -1, geom, along, None, count, mujoco.mjMAXVAL
        )
        distance[geom >= 0] = along[geom >= 0]
    return found
