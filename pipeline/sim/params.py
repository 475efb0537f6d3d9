"""What params.yaml says of a scene; lengths in metres, world frame, x forward, y left, z up."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from pipeline.contract.params import Section

Axis = Literal["x", "y", "z"]
# A desk or a floor with a robot arm; what lies beyond these bounds is a slip of the keyboard.
Metres = Annotated[float, Field(ge=-100, le=100)]
Distance = Annotated[float, Field(ge=0, le=100)]
Positive = Annotated[float, Field(gt=0, le=100)]
Share = Annotated[float, Field(ge=0, le=1)]
Vector = tuple[Metres, Metres, Metres]
AXES: tuple[Axis, ...] = ("x", "y", "z")


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
    """Where the tip may start on the controlled axes; on the others it starts at the target's place.

    ``above_target_m``: least height above the target, or null where the tip may start below it.
    """

    above_target_m: Distance | None


class Target(Section):
    """The red sphere to reach: one of the candidates, moved by up to ± jitter on each axis."""

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
    """A scene: robot, desk, controlled axes, start, targets, obstacles, camera, lights.

    ``desk``: a box to stand on and lean on, or null where there is none or the robot's file brings one.
    """

    robot: str
    desk: Box | None
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
    def _target_within_workspace(self) -> SceneParams:
        for candidate in self.target.candidates_m:
            for axis in self.axes:
                i = AXES.index(axis)
                low, high = candidate[i] - self.target.jitter_m[i], candidate[i] + self.target.jitter_m[i]
                if low < self.workspace.low_m[i] - 1e-9 or high > self.workspace.high_m[i] + 1e-9:
                    raise ValueError(
                        f"target candidate {candidate} with jitter {self.target.jitter_m} leaves the "
                        f"workspace [{self.workspace.low_m[i]}, {self.workspace.high_m[i]}] m on axis {axis}"
                    )
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
