"""What is asked of the station, and its check against scenes and viewpoints."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipeline.contract import params
from pipeline.contract.errors import unknown
from pipeline.contract.params import Section
from pipeline.contract.viewpoints import STUDY, Viewpoint, named_viewpoints
from pipeline.sim.params import SceneParams

Frame = Literal["robot", "camera"]
RendererName = Literal["auto", "mujoco", "ray tracer"]
Pixels = Annotated[int, Field(ge=64, le=1920, multiple_of=16)]
_SAME = 1e-6


class StationParams(Section):
    """Section ``station``.

    Attributes:
        frame: of the sticks' horizontal plane: robot (x away from its base, y to its left) or camera.
        picture: width and height, pixels.
        renderer: ``auto`` takes MuJoCo's own where it is fast enough, else the ray tracer.
        frames_per_second: control frames, as every scene of ``tasks`` has them.
        dead_zone: share of a stick's travel in which nothing moves.
        speed_m_s: of the tip's setpoint at a full stick.
        practice_s: shortest and longest practice.
        trial_limit_s: after so long from the first input a trial ends as a timeout.
        trials: of a block, which is a scene seen from one view.
        tasks: the scenes, in the order of params.yaml; the order in a session is drawn.
        views_per_task: how many viewpoints of a scene are compared: its first ones.
        feedback: whether time and distance are told after a trial.
        tlx: whether NASA-TLX is asked after each block.
    """

    frame: Frame
    picture: tuple[Pixels, Pixels]
    renderer: RendererName
    frames_per_second: Annotated[int, Field(ge=1, le=240)]
    dead_zone: Annotated[float, Field(ge=0, lt=0.9)]
    speed_m_s: Annotated[float, Field(gt=0, le=2)]
    practice_s: tuple[Annotated[float, Field(ge=0)], Annotated[float, Field(gt=0, le=7200)]]
    trial_limit_s: Annotated[float, Field(ge=1, le=3600)]
    trials: Annotated[int, Field(ge=1, le=100)]
    tasks: Annotated[tuple[str, ...], Field(min_length=1)]
    views_per_task: Annotated[int, Field(ge=1, le=12)]
    feedback: bool
    tlx: bool

    @model_validator(mode="after")
    def _ordered(self) -> StationParams:
        if self.practice_s[1] < self.practice_s[0]:
            raise ValueError(f"practice_s {list(self.practice_s)} has its shortest time first")
        if len(set(self.tasks)) < len(self.tasks):
            raise ValueError(f"tasks {list(self.tasks)} names a scene twice")
        return self


def station_params(path: Path = params.PARAMS_FILE, tasks: tuple[str, ...] | None = None) -> StationParams:
    """Section ``station``, held against the scenes that it names.

    Args:
        path: the parameter file.
        tasks: scenes to take instead of the section's.

    Raises:
        BelvedereError: a value is not valid, a scene is unknown, has another task than reaching, another
            number of frames a second or no viewpoint.
    """
    given = params.section(StationParams, "station", path=path)
    given = given if tasks is None else given.model_copy(update={"tasks": tasks})
    scenes = params.mapping("scenes", path=path)
    for scene in given.tasks:
        if scene not in scenes:
            raise unknown(f"{path}: scene below station.tasks", scene, scenes)
        check_scene(scene, given, path)
    return given


def check_scene(scene: str, given: StationParams, path: Path) -> None:
    """Raises a BelvedereError where the station cannot run ``scene``."""
    described = params.section(SceneParams, "scenes", scene, path=path)
    if described.task.kind != "reach":
        why = f"the station measures reaching (paper section IV-C), and its task is {described.task.kind}"
        raise params.invalid(path, "station.tasks", scene, why)
    frame_s = described.substeps * described.timestep_s
    if abs(given.frames_per_second * frame_s - 1) > _SAME:
        why = f"scene {scene} has substeps × timestep_s = {frame_s:g} s, so {1 / frame_s:g} frames a second"
        raise params.invalid(path, "station.frames_per_second", given.frames_per_second, why)
    if not candidates(scene, path):
        raise params.invalid(path, "station.tasks", scene, "no viewpoint below viewpoints is of this scene")


def candidates(scene: str, path: Path = params.PARAMS_FILE) -> dict[str, Viewpoint]:
    """The scene's viewpoints by name, in the order of params.yaml."""
    named = named_viewpoints(path)
    return {name: view for name, view in named.items() if view.scene == scene and name != STUDY}
