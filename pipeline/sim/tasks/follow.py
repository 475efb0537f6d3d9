"""Follow: the tip is to stay at a sphere that moves along a closed path."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from pipeline.sim.tasks.base import State, Task
from pipeline.sim.units import AXES, Distance, Positive

if TYPE_CHECKING:
    from pipeline.sim.params import SceneParams

_Degrees = Annotated[float, Field(ge=-360, le=360)]
_Cycles = Annotated[int, Field(ge=1, le=9)]
_LEAD_FRAMES = 2.0  # the arm comes to a setpoint about so many frames later


class Follow(Task):
    """The target moves about its place on a Lissajous path, a sine on each axis; from where is drawn.

    Attributes:
        radius_m: amplitude on each axis, 0 where it rests; equal ones on two axes with phases a quarter
            period apart are a circle.
        cycles: sines a period on each axis; unlike ones make a figure of eight or more.
        phase_deg: of each axis' sine against the others.
        period_s: after which the path repeats.
        hold_frames: how long the tip must have been near for the task to count as done.
    """

    moves: ClassVar[bool] = True
    drawn_size: ClassVar[int] = 1  # where on the path an episode starts, rad

    kind: Literal["follow"]
    radius_m: tuple[Distance, Distance, Distance]
    cycles: tuple[_Cycles, _Cycles, _Cycles]
    phase_deg: tuple[_Degrees, _Degrees, _Degrees]
    period_s: Positive
    hold_frames: Annotated[int, Field(ge=1, le=10_000)]

    def check(self, scene: SceneParams) -> None:
        for axis, radius_m in zip(AXES, self.radius_m, strict=True):
            if radius_m and axis not in scene.axes:
                raise ValueError(
                    f"task.radius_m {list(self.radius_m)} moves the target along {axis}, which the scene "
                    f"does not control; its axes are {list(scene.axes)}"
                )
        if not any(self.radius_m):
            raise ValueError(
                "task.radius_m is 0 on every axis, so nothing moves; for that there is kind reach"
            )
        if scene.obstacles:
            raise ValueError("a target that moves could pass through obstacles; task follow takes none")
        if self.hold_frames > scene.frames:
            raise ValueError(
                f"task.hold_frames {self.hold_frames} is more than the {scene.frames} frames there are"
            )
        self.within_workspace(scene, np.array(self.radius_m))

    def draw(
        self, scene: SceneParams, start_m: np.ndarray, target_m: np.ndarray, rng: np.random.Generator
    ) -> np.ndarray:
        return rng.uniform(0.0, 2 * np.pi, (len(start_m), 1))

    def targets(self, scene: SceneParams, target_m: np.ndarray, drawn: np.ndarray) -> np.ndarray:
        seconds = np.arange(scene.frames + 1) * scene.substeps * scene.timestep_s
        angle = drawn + 2 * np.pi * seconds / self.period_s  # (n, t + 1)
        sines = np.sin(angle[:, :, None] * self.cycles + np.radians(self.phase_deg))
        return np.asarray(target_m[:, None] + np.array(self.radius_m) * sines)

    def succeeded(self, error_m: np.ndarray, near_m: float) -> np.ndarray:
        """Near now and in the frames before, ``hold_frames`` in all."""
        near = error_m < near_m
        held = np.zeros_like(near)
        for time in range(self.hold_frames - 1, near.shape[1]):
            held[:, time] = near[:, time + 1 - self.hold_frames : time + 1].all(axis=1)
        return held

    def aim(self, state: State) -> np.ndarray:
        """Ahead of the target, since the arm lags."""
        return state.target_m + _LEAD_FRAMES * (state.next_target_m - state.target_m)
