"""The types of values that params.yaml gives of scenes and tasks; lengths in metres, world frame."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

Axis = Literal["x", "y", "z"]
# A desk or a floor with a robot arm; what lies beyond these bounds is a slip of the keyboard.
Metres = Annotated[float, Field(ge=-100, le=100)]
Distance = Annotated[float, Field(ge=0, le=100)]
Positive = Annotated[float, Field(gt=0, le=100)]
Share = Annotated[float, Field(ge=0, le=1)]
Vector = tuple[Metres, Metres, Metres]
AXES: tuple[Axis, ...] = ("x", "y", "z")
