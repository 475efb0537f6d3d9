"""Align: the tip is to come above a container, to release what it holds, or a peg above a hole."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import mujoco
import numpy as np
from pydantic import Field, model_validator

from pipeline.contract.params import Section
from pipeline.sim.tasks.base import Task
from pipeline.sim.tasks.bodies import add_disc, add_target_geom
from pipeline.sim.units import AXES, Axis, Distance, Positive

if TYPE_CHECKING:
    from pipeline.sim.params import SceneParams

_WALL_RGBA = (0.85, 0.55, 0.15, 1.0)


class Container(Section):
    """A box that is open above; without a floor and with wide walls it is a plate with a square hole.

    Attributes:
        half_size_m: of its outside, x, y and z.
        wall_m: how thick walls and floor are.
        floor: whether it has one.
    """

    half_size_m: tuple[Positive, Positive, Positive]
    wall_m: Positive
    floor: bool

    @model_validator(mode="after")
    def _open(self) -> Container:
        if self.wall_m >= min(self.half_size_m[:2]):
            raise ValueError(f"wall_m {self.wall_m} leaves no opening in half_size_m {self.half_size_m}")
        if self.floor and self.wall_m >= 2 * self.half_size_m[2]:
            raise ValueError(f"a floor of wall_m {self.wall_m} fills the height of {self.half_size_m}")
        return self


class Align(Task):
    """The tip is to stand above the container, which stands on the target's place.

    Attributes:
        axes: those on which the distance counts, of the axes that the scene controls.
        above_m: how far above the container's rim the tip is to be; where the scene does not control z, it
            is there from the start.
        container: its size.
    """

    kind: Literal["align"]
    axes: Annotated[tuple[Axis, ...], Field(min_length=1, max_length=3)]
    above_m: Distance
    container: Container

    @property
    def offset_m(self) -> np.ndarray:
        return np.array([0.0, 0.0, 2 * self.container.half_size_m[2] + self.above_m])

    @property
    def counted(self) -> np.ndarray:
        return np.array([float(axis in self.axes) for axis in AXES])

    def check(self, scene: SceneParams) -> None:
        for axis in self.axes:
            if axis not in scene.axes:
                raise ValueError(
                    f"task.axes {list(self.axes)} has {axis}, which the scene does not control; its axes are "
                    f"{list(scene.axes)}"
                )
        super().check(scene)

    def extent_m(self, scene: SceneParams) -> float:
        x, y, z = self.container.half_size_m
        return float(np.linalg.norm([x, y, 2 * z]))

    def add_bodies(self, spec: mujoco.MjSpec, scene: SceneParams) -> None:
        x, y, z = self.container.half_size_m
        wall_m, half = self.container.wall_m, self.container.wall_m / 2
        base_m = wall_m if self.container.floor else 0.0
        body = add_disc(spec, scene.target.candidates_m[0], scene.target.radius_m, base_m)
        boxes = [((side * (x - half), 0.0, z), (half, y, z)) for side in (-1, 1)]
        boxes += [((0.0, side * (y - half), z), (x - wall_m, half, z)) for side in (-1, 1)]
        if self.container.floor:
            boxes.append(((0.0, 0.0, half), (x - wall_m, y - wall_m, half)))
        for place_m, half_size_m in boxes:
            add_target_geom(body, mujoco.mjtGeom.mjGEOM_BOX, half_size_m, place_m, _WALL_RGBA)
