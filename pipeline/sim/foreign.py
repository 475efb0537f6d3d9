"""What of a foreign robot file becomes part of a scene, and what is left out or refused."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from pipeline.contract.errors import BelvedereError, unknown
from pipeline.sim.robot import HIDDEN_GROUP, Robot

DRAWN_GROUP = 0  # the target stands alone in group 1, where many files have their visuals
_LAST_DRAWN = 2  # MuJoCo itself draws geoms of groups 0 to 2
_MOVES = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_LEFT_OUT = ("lights", "cameras", "keys", "sensors", "pairs", "excludes")


def found(name: str, file: Path, kind: str, wanted: str, elements: Sequence[Any]) -> Any:
    """The file's element of this name.

    Raises:
        BelvedereError: there is none; tells those that there are.
    """
    for element in elements:
        if element.name == wanted:
            return element
    raise unknown(f"robot {name}: {kind} (of {file.name})", wanted, [e.name for e in elements if e.name])


def cleaned(name: str, file: Path, spec: mujoco.MjSpec, remove: Sequence[str]) -> list[str]:
    """Takes out of the spec what is no part of the robot, and says what was dropped without being named.

    Raises:
        BelvedereError: a body to be removed is unknown, or one moves as no part of an arm does.
    """
    for body in remove:
        spec.delete(found(name, file, "body to remove", body, spec.bodies[1:]))
    dropped = []
    for kind in _LEFT_OUT:
        for element in list(getattr(spec, kind)):
            dropped += (
                [f"{kind[:-1]} {element.name or 'without name'}"] if kind in ("lights", "cameras") else []
            )
            spec.delete(element)
    for geom in list(spec.worldbody.geoms):
        dropped.append(f"world geom {geom.name or mujoco.mjtGeom(geom.type).name}")
        spec.delete(geom)
    for texture in list(spec.textures):
        if texture.type == mujoco.mjtTexture.mjTEXTURE_SKYBOX:
            spec.delete(texture)
    _refuse_what_floats(name, file, spec)
    for body in spec.bodies[1:]:
        _choose_visible(body)
    return dropped


def _refuse_what_floats(name: str, file: Path, spec: mujoco.MjSpec) -> None:
    for body in spec.bodies[1:]:
        odd = [
            mujoco.mjtJoint(j.type).name.removeprefix("mjJNT_").lower()
            for j in body.joints
            if j.type not in _MOVES
        ]
        if body.mocap or odd:
            what = "is a mocap body" if body.mocap else f"has a {odd[0]} joint"
            raise BelvedereError(
                f"robot {name}: body {body.name} of {file.name} {what}, which no arm has; if it is no part "
                f"of the robot, name it in robots.{name}.remove: [{body.name}]."
            )


def _choose_visible(body: mujoco.MjsBody) -> None:
    """Draws a body's visual geoms and hides the colliding ones; draws these where it has no visual ones."""
    touching = [g for g in body.geoms if g.contype or g.conaffinity]
    visual = [g for g in body.geoms if not (g.contype or g.conaffinity) and g.group <= _LAST_DRAWN]
    for geom in body.geoms:
        geom.group = HIDDEN_GROUP
    for geom in visual or touching:
        geom.group = DRAWN_GROUP


def refuse_textures(model: mujoco.MjModel, robot: Robot) -> None:
    """Raises a :class:`BelvedereError` if a drawn geom's material has a texture: none is drawn."""
    for geom in np.flatnonzero((model.geom_group <= _LAST_DRAWN) & (model.geom_matid >= 0)):
        material = model.geom_matid[geom]
        if (model.mat_texid[material] >= 0).any():
            names = model.mat(material).name, model.body(model.geom_bodyid[geom]).name
            which, body = (name.removeprefix(robot.prefix) for name in names)
            raise BelvedereError(
                f"robot {robot.name}: material {which} of {robot.files[0].name} covers a geom of body "
                f"{body} with a texture, which is not drawn; take the attribute texture out of the material, "
                "whose rgba is drawn then."
            )
