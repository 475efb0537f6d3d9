"""A scene's robot from six sides in one picture, and what a picture of it costs."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from PIL import Image

from pipeline.contract.viewpoints import viewpoint
from pipeline.rendering.buffers import visible_geoms
from pipeline.rendering.renderer import VISIBLE_GROUPS, Renderer
from pipeline.sim.scene import Scene, initial_data
from pipeline.storage.artefacts import writing

_SIDES = ((0, 15), (45, 30), (90, 15), (180, 15), (270, 15), (0, 85))  # θ, φ, degrees
_SIZE = 320  # of each, pixels
_CLOSER = 0.75  # bounding spheres of long links reach past them
_WORLDS = 32  # a call, as the stage frames draws them
_ROUNDS = 5


def write_six_sides(scene: Scene, out: Path) -> None:
    """Writes a PNG, two rows of three pictures: the robot at home, and its first target."""
    whole = _with_all_in_sight(scene)
    qpos, target = _at_home(scene, 1)
    drawn = [
        Renderer(whole, viewpoint(scene.name, *side), 1, size=_SIZE, antialias=2)
        .render(qpos, target)[0]
        .copy()
        for side in _SIDES
    ]
    rows = [np.concatenate(drawn[place : place + 3], axis=1) for place in (0, 3)]
    with writing(out) as aside, aside.open("wb") as file:
        Image.fromarray(np.concatenate(rows)).save(file, format="png")


def _with_all_in_sight(scene: Scene) -> Scene:
    """The scene with its camera far enough away, and on the middle of all that is drawn."""
    model, data = scene.model, initial_data(scene)
    drawn = visible_geoms(model, VISIBLE_GROUPS)
    middles, reach = data.geom_xpos[drawn], model.geom_rbound[drawn, None]
    low, high = (middles - reach).min(axis=0), (middles + reach).max(axis=0)
    far = _CLOSER * np.linalg.norm(high - low) / 2 / np.sin(np.radians(scene.params.camera.fov_deg) / 2)
    changes = {"look_at_m": tuple(((low + high) / 2).tolist()), "distance_m": float(far)}
    camera = scene.params.camera.model_copy(update=changes)
    return replace(scene, params=scene.params.model_copy(update={"camera": camera}))


def milliseconds_a_picture(scene: Scene) -> float:
    """What a 64 × 64 picture takes on one core, best of some rounds."""
    renderer = Renderer(scene, viewpoint(scene.name, 45, 30), _WORLDS)
    qpos, target = _at_home(scene, _WORLDS)
    renderer.render(qpos, target)  # compiles
    taken = []
    for _ in range(_ROUNDS):
        begun = time.perf_counter()
        renderer.render(qpos, target)
        taken.append(time.perf_counter() - begun)
    return 1000 * min(taken) / _WORLDS


def drawn_faces(model: mujoco.MjModel) -> int:
    """How many faces the meshes have that a picture shows."""
    meshes = [
        g for g in visible_geoms(model, VISIBLE_GROUPS) if model.geom_type[g] == mujoco.mjtGeom.mjGEOM_MESH
    ]
    return int(model.mesh_facenum[model.geom_dataid[meshes]].sum())


def _at_home(scene: Scene, count: int) -> tuple[np.ndarray, np.ndarray]:
    qpos = np.repeat(initial_data(scene).qpos.astype(np.float32)[None], count, axis=0)
    return qpos, np.repeat(np.asarray(scene.params.target.candidates_m[:1]), count, axis=0)
