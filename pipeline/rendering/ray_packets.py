"""Packets of rays, and where a ray intersects a primitive."""

from __future__ import annotations

import warp as wp
from mujoco import mjtGeom
from mujoco_warp._src import ray  # private; tests/rendering/test_renderer.py watches it

SIDE = 4  # of a packet, samples
LANES = SIDE * SIDE

PLANE, _SPHERE, _CAPSULE = int(mjtGeom.mjGEOM_PLANE), int(mjtGeom.mjGEOM_SPHERE), int(mjtGeom.mjGEOM_CAPSULE)
_CYLINDER, _ELLIPSOID = int(mjtGeom.mjGEOM_CYLINDER), int(mjtGeom.mjGEOM_ELLIPSOID)
_BOX, MESH = int(mjtGeom.mjGEOM_BOX), int(mjtGeom.mjGEOM_MESH)
KINDS = (PLANE, _SPHERE, _CAPSULE, _CYLINDER, _ELLIPSOID, _BOX, MESH)


@wp.func
def intersect_primitive(
    kind: int, size: wp.vec3, position: wp.vec3, rotation: wp.mat33, origin: wp.vec3, direction: wp.vec3
) -> tuple[float, wp.vec3]:
    """Distance (negative: none) and normal."""
    distance = wp.float32(-1.0)
    normal = wp.vec3(0.0)
    if kind == wp.static(_SPHERE):
        distance, normal = ray.ray_sphere(position, size[0] * size[0], origin, direction)
    elif kind == wp.static(_BOX):
        distance, _, normal = ray.ray_box(position, rotation, size, origin, direction)
    elif kind == wp.static(PLANE):
        distance, normal = ray.ray_plane(position, rotation, size, origin, direction)
    elif kind == wp.static(_CAPSULE):
        distance, normal = ray.ray_capsule(position, rotation, size, origin, direction)
    elif kind == wp.static(_CYLINDER):
        distance, normal = ray.ray_cylinder(position, rotation, size, origin, direction)
    elif kind == wp.static(_ELLIPSOID):
        distance, normal = ray.ray_ellipsoid(position, rotation, size, origin, direction)
    return distance, normal
