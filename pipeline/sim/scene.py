"""Scenes: a robot, a desk, obstacles, a target and lights, compiled into one MuJoCo model."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import mujoco
from pydantic import ValidationError

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.sim import servos
from pipeline.sim.foreign import refuse_textures
from pipeline.sim.params import AXES, Box, Camera, SceneParams
from pipeline.sim.robot import TIP, Robot
from pipeline.sim.robot_files import digests
from pipeline.sim.robot_params import RobotParams, robot_params
from pipeline.sim.robots import build_robot, limit_contacts
from pipeline.sim.tasks.base import Task
from pipeline.sim.tasks.bodies import TARGET

CAMERA = "viewpoint"
_OBSTACLE_RGBA = (0.2, 0.45, 0.75, 1.0)
_DESK_RGBA = (0.62, 0.55, 0.46, 1.0)


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled scene.

    Attributes:
        name: its name in params.yaml.
        params: what params.yaml says of it.
        model: the compiled model; its camera :data:`CAMERA` is placed by the renderers.
        robot: how the robot is moved.
        declared: what params.yaml says of the robot.
    """

    name: str
    params: SceneParams
    model: mujoco.MjModel
    robot: Robot
    declared: RobotParams

    @property
    def axes(self) -> tuple[int, ...]:
        """Indices (x 0, y 1, z 2) of the controlled axes."""
        return tuple(AXES.index(axis) for axis in self.params.axes)

    @property
    def action_size(self) -> int:
        return len(self.params.axes)

    @property
    def frames(self) -> int:
        """Frames, so also actions, of an episode."""
        return self.params.frames

    @cached_property
    def cache_key(self) -> dict[str, Any]:
        """All that a result of the scene follows from but code: what a cache of results goes by."""
        described = {"scene": self.params.model_dump(), "robot": self.declared.model_dump()}
        return {**described, "files": digests(self.robot.files)}

    @cached_property
    def tip_site(self) -> int:
        return int(self.model.site(TIP).id)

    @cached_property
    def target_mocap(self) -> int:
        return int(self.model.body(TARGET).mocapid[0])

    @property
    def task(self) -> Task:
        return self.params.task

    @cached_property
    def point_site(self) -> int:
        """The site that shall come to the target."""
        return int(self.model.site(self.task.site).id)

    @cached_property
    def target_geoms(self) -> range:
        """The target's geoms, which are numbered one after the other."""
        body = self.model.body(TARGET)
        first = int(body.geomadr[0])
        return range(first, first + int(body.geomnum[0]))


def load_scene(name: str, path: Path = params.PARAMS_FILE, root: Path | None = None) -> Scene:
    """Reads scene ``name`` from params.yaml and compiles it.

    Args:
        name: of the scene.
        path: the parameter file.
        root: the folder that holds ``robots/``, if that is not the parameter file's.

    Raises:
        BelvedereError: the scene is unknown or badly described, or its robot's files are missing.
    """
    scenes = params.value("scenes", path=path)
    if name not in scenes:
        raise unknown(f"scene (in {path})", name, scenes)
    described = params.section(SceneParams, "scenes", name, path=path)
    return compile_scene(name, described, robot_params(described.robot, path), root or path.parent)


def compile_scene(name: str, scene: SceneParams, declared: RobotParams, root: Path) -> Scene:
    """Compiles a described scene with a described robot, whose files may lie below ``root``."""
    spec, robot = build_robot(scene.robot, declared, root)
    spec.option.timestep = scene.timestep_s
    _add_lights(spec, scene)
    if scene.desk is not None:
        _add_box(spec, "desk", scene.desk, _DESK_RGBA)
    for index, box in enumerate(scene.obstacles):
        _add_box(spec, f"obstacle{index}", box, _OBSTACLE_RGBA)
    limit_contacts(spec, robot)
    scene.task.add_bodies(spec, scene)
    spec.worldbody.add_camera(name=CAMERA, fovy=scene.camera.fov_deg)
    try:
        model = spec.compile()
    except ValueError as error:
        raise BelvedereError(
            f"scene {name}: robot {scene.robot!r} does not compile: {' '.join(str(error).split())}."
        ) from None
    refuse_textures(model, robot)
    servos.tune(model, robot, declared.drive)
    return Scene(name, scene, model, robot, declared)


def with_camera(scene: Scene, distance_m: float, fov_deg: float) -> Scene:
    """The scene with its camera at another distance and with another field of view; 0 leaves the scene's.

    Raises:
        BelvedereError: no camera has them.
    """
    wanted = {"distance_m": distance_m, "fov_deg": fov_deg}
    changes = {name: value for name, value in wanted.items() if value}
    before = scene.params.camera
    try:
        camera = Camera.model_validate(before.model_dump() | changes)
    except ValidationError:
        raise BelvedereError(
            f"scene {scene.name}: a camera {distance_m:g} m away with a field of view of {fov_deg:g} degrees "
            "is not valid; the distance is above 0 m, the field of view above 0 and below 170 degrees."
        ) from None
    if camera == before:
        return scene
    model = copy.copy(scene.model)
    model.cam_fovy[model.camera(CAMERA).id] = camera.fov_deg
    return replace(scene, params=scene.params.model_copy(update={"camera": camera}), model=model)


def _add_box(spec: mujoco.MjSpec, name: str, box: Box, rgba: tuple[float, ...]) -> None:
    spec.worldbody.add_geom(
        name=name, type=mujoco.mjtGeom.mjGEOM_BOX, pos=box.center_m, size=box.half_size_m, rgba=rgba
    )


def _add_lights(spec: mujoco.MjSpec, scene: SceneParams) -> None:
    """Light that is alike for every pan angle, without specular highlights or shadows."""
    light = scene.light
    spec.visual.headlight.active = 1
    spec.visual.headlight.ambient = [light.ambient] * 3
    spec.visual.headlight.diffuse = [light.camera] * 3
    spec.visual.headlight.specular = [0.0] * 3
    spec.worldbody.add_light(
        name="above",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=[0, 0, 4],
        dir=[0, 0, -1],
        ambient=[0.0] * 3,
        diffuse=[light.above] * 3,
        specular=[0.0] * 3,
        castshadow=False,
    )
    # MuJoCo's own renderer paints the background from a sky; the ray tracer takes the colour itself.
    spec.add_texture(
        name="background",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=light.background_rgb,
        rgb2=light.background_rgb,
        width=8,
        height=48,
    )


def initial_data(scene: Scene) -> mujoco.MjData:
    """The state from which episodes are set up: the robot at its home, settled where it has to be."""
    data = mujoco.MjData(scene.model)
    for joint, position in scene.robot.home.items():
        data.joint(joint).qpos[:] = position
    if scene.robot.settle is not None:
        scene.robot.settle(scene.model, data)
    mujoco.mj_forward(scene.model, data)
    data.time = 0.0
    return data
