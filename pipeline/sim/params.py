"""What params.yaml says of a scene; lengths in metres, world frame, x forward, y left, z up."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field, model_validator

from pipeline.contract.params import Section
from pipeline.sim.tasks import REACH, AnyTask
from pipeline.sim.units import AXES as AXES
from pipeline.sim.units import Axis as Axis
from pipeline.sim.units import Distance as Distance
from pipeline.sim.units import Metres as Metres
from pipeline.sim.units import Positive as Positive
from pipeline.sim.units import Share as Share
from pipeline.sim.units import Vector as Vector


class Box(Section):
    """An axis-aligned solid box."""

    center_m: Vector
    half_size_m: tuple[Positive, Positive, Positive]


class Range(Section):
    """An axis-aligned range of positions."""

    low_m: Vector
    high_m: Vector

    @model_validator(mode="after")
    def _ordered(self) -> Range:
        if any(low > high for low, high in zip(self.low_m, self.high_m, strict=True)):
            raise ValueError(f"low_m {self.low_m} must not lie above high_m {self.high_m}")
        return self


class Start(Range):
    """Where the tip may start on the controlled axes; on the others it starts where the task has its goal.

    ``above_target_m``: least height above the target, or null where the tip may start below it.
    """

    above_target_m: Distance | None


class Target(Section):
    """The red target: at one of the candidates, moved by up to ± jitter on each controlled axis.

    ``radius_m``: of the red marker, a sphere or a disc; what else stands there is the task's.
    """

    candidates_m: Annotated[tuple[Vector, ...], Field(min_length=1)]
    jitter_m: tuple[Distance, Distance, Distance]
    radius_m: Positive


class Camera(Section):
    """What all viewpoints of a scene share.

    ``front_deg`` turns θ = 0°: at 0 the camera stands in front of the robot and looks along x.
    """

    look_at_m: Vector
    distance_m: Positive
    fov_deg: Annotated[float, Field(gt=0, lt=170)]
    front_deg: Annotated[float, Field(ge=-360, le=360)]


class Light(Section):
    """Lights that are symmetric about the vertical: one from straight above, one at the camera."""

    ambient: Share
    above: Share
    camera: Share
    background_rgb: tuple[Share, Share, Share]


class SceneParams(Section):
    """A scene: robot, desk, task, controlled axes, start, targets, obstacles, camera, lights.

    ``desk``: a box to stand on and lean on, or null where there is none or the robot's file brings one.
    """

    robot: str
    desk: Box | None
    task: AnyTask = REACH
    axes: Annotated[tuple[Axis, ...], Field(min_length=1, max_length=3)]
    frames: Annotated[int, Field(ge=1, le=10_000)]
    substeps: Annotated[int, Field(ge=1, le=1000)]
    timestep_s: Annotated[float, Field(gt=0, le=0.05)]
    displacement_m: Annotated[float, Field(gt=0, le=1)]
    workspace: Range
    start: Start
    target: Target
    obstacles: tuple[Box, ...]
    obstacle_clearance_m: Distance
    camera: Camera
    light: Light

    @model_validator(mode="after")
    def _axes_ordered(self) -> SceneParams:
        indices = [AXES.index(axis) for axis in self.axes]
        if indices != sorted(set(indices)):
            raise ValueError(f"axes {list(self.axes)} must be some of x, y, z, each once, in this order")
        return self

    @model_validator(mode="after")
    def _task_fits(self) -> SceneParams:
        self.task.check(self)
        return self


class ExplorationParams(Section):
    """Section ``rollouts``: an Ornstein-Uhlenbeck process per axis.

    Attributes:
        correlation: of an action with the one a frame before.
        deviation: stationary standard deviation, shares of the largest displacement.
    """

    correlation: Annotated[float, Field(ge=0, lt=1)]
    deviation: Annotated[float, Field(gt=0, le=100)]


class RolloutSizes(Section):
    """Section ``budgets.*.rollouts``: ``episodes`` of each repeat."""

    episodes: Annotated[int, Field(ge=2, le=1_000_000)]
