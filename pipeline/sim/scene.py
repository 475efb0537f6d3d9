"""Scenes: a robot, a desk, obstacles, a target and lights, compiled into one MuJoCo model."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.sim.params import AXES, SceneParams
from pipeline.sim.robots import TIP, Robot, limit_contacts, robot, settle_fetch
from pipeline.sim.tasks.base import Task
from pipeline.sim.tasks.bodies import TARGET

CAMERA = "viewpoint"
_OBSTACLE_RGBA = (0.2, 0.45, 0.75, 1.0)
_DESK_RGBA = (0.62, 0.55, 0.46, 1.0)
_PANDA_DESK = ((0.45, 0.0, -0.02), (0.55, 0.7, 0.02))  # centre and half size, m; its top is z = 0


@dataclass(frozen=True, eq=False)
class Scene:
    """A compiled scene.

    Attributes:
        name: its name in params.yaml.
        params: what params.yaml says of it.
        model: the compiled model; its camera :data:`CAMERA` is placed by the renderers.
        robot: how the robot is moved.
    """

    name: str
    params: SceneParams
    model: mujoco.MjModel
    robot: Robot

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


def load_scene(name: str, path: Path = params.PARAMS_FILE) -> Scene:
    """Reads scene ``name`` from params.yaml and compiles it.

    Raises:
        BelvedereError: the scene is unknown or badly described, or its robot's files are missing.
    """
    scenes = params.value("scenes", path=path)
    if name not in scenes:
        raise unknown(f"scene (in {path})", name, scenes)
    return compile_scene(name, params.section(SceneParams, "scenes", name, path=path))


def compile_scene(name: str, scene: SceneParams) -> Scene:
    """Compiles a described scene."""
    arm = robot(scene.robot)
    spec = arm.build()
    spec.option.timestep = scene.timestep_s
    _add_lights(spec, scene)
    _add_desk(spec, scene)
    for index, box in enumerate(scene.obstacles):
        spec.worldbody.add_geom(
            name=f"obstacle{index}",
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=box.center_m,
            size=box.half_size_m,
            rgba=_OBSTACLE_RGBA,
            contype=1,
            conaffinity=1,
        )
    limit_contacts(spec, arm)
    scene.task.add_bodies(spec, scene)
    spec.worldbody.add_camera(name=CAMERA, fovy=scene.camera.fov_deg)
    try:
        model = spec.compile()
    except ValueError as error:
        raise BelvedereError(
            f"scene {name}: robot {scene.robot!r} does not compile: {' '.join(str(error).split())}."
        ) from None
    return Scene(name, scene, model, arm)


def _add_desk(spec: mujoco.MjSpec, scene: SceneParams) -> None:
    if scene.robot == "fetch":  # FetchReach brings its own table
        return
    center, half_size = _PANDA_DESK
    spec.worldbody.add_geom(
        name="desk", type=mujoco.mjtGeom.mjGEOM_BOX, pos=center, size=half_size, rgba=_DESK_RGBA
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
    """The state from which episodes are set up: settled (Fetch) or at the robot's home (Panda)."""
    data = mujoco.MjData(scene.model)
    for joint, angle_rad in scene.robot.home.items():
        data.joint(joint).qpos[:] = angle_rad
    if scene.robot.control == "mocap":
        settle_fetch(scene.model, data)
    mujoco.mj_forward(scene.model, data)
    data.time = 0.0
    return data
