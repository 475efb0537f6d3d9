"""The target of a scene: a mocap body, which can stand anywhere and nothing can touch."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

TARGET = "target"
TARGET_GROUP = 1  # the target's geoms alone, so that it can be pictured without what hides it
HIDDEN_GROUP = 4  # sites of this group are in no picture
_DISC_HALF_HEIGHT_M = 0.0015
TARGET_RGBA = (1.0, 0.0, 0.0, 1.0)


def add_marker(spec: mujoco.MjSpec, place_m: Sequence[float], radius_m: float) -> None:
    """A red sphere."""
    add_target_geom(_target(spec, place_m), mujoco.mjtGeom.mjGEOM_SPHERE, [radius_m, 0, 0])


def add_disc(
    spec: mujoco.MjSpec, place_m: Sequence[float], radius_m: float, base_m: float = 0.0
) -> mujoco.MjsBody:
    """A flat red disc that lies ``base_m`` above the target's place; returns the target's body."""
    body = _target(spec, place_m)
    size = [radius_m, _DISC_HALF_HEIGHT_M, 0]
    add_target_geom(body, mujoco.mjtGeom.mjGEOM_CYLINDER, size, pos=[0, 0, base_m + _DISC_HALF_HEIGHT_M])
    return body


def add_target_geom(
    body: mujoco.MjsBody,
    kind: mujoco.mjtGeom,
    size: Sequence[float],
    pos: Sequence[float] = (0.0, 0.0, 0.0),
    rgba: Sequence[float] = TARGET_RGBA,
) -> None:
    """A geom of the target, of a size (3,) as MuJoCo has it, at a place in its body."""
    first = not body.geoms
    body.add_geom(
        name=TARGET if first else f"{TARGET}{len(body.geoms)}",
        type=kind,
        size=size,
        pos=pos,
        rgba=rgba,
        contype=0,
        conaffinity=0,
        group=TARGET_GROUP,
    )


def _target(spec: mujoco.MjSpec, place_m: Sequence[float]) -> mujoco.MjsBody:
    return spec.worldbody.add_body(name=TARGET, mocap=True, pos=place_m)
