"""What params.yaml says of a robot: its file, its tip, how it is moved. Defaults stand here only."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from pipeline.contract import params
from pipeline.contract.errors import unknown
from pipeline.contract.params import Section
from pipeline.sim.params import Vector

# Radians of a joint that turns, metres of one that slides.
Position = Annotated[float, Field(ge=-100, le=100)]
Name = Annotated[str, Field(min_length=1)]


class Base(Section):
    """Where the file's origin stands in the world, and how far it is turned about the vertical."""

    position_m: Vector = (0.0, 0.0, 0.0)
    turn_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0


class Tip(Section):
    """The point that reaches for targets: a site or a body of the file, and an offset in its frame."""

    site: Name | None = None
    body: Name | None = None
    offset_m: Vector = (0.0, 0.0, 0.0)

    @model_validator(mode="after")
    def _one(self) -> Tip:
        if (self.site is None) == (self.body is None):
            raise ValueError("tip names a site or a body of the robot's file, one of the two")
        return self


class Drive(Section):
    """How the joints follow.

    Attributes:
        actuators: ``added``: a position servo is made for each joint of the arm, and takes the place of the
            joint's own friction; ``own``: the file's position actuators; ``weld``: a weld to a mocap body
            pulls the tip (``build: fetch_reach`` only).
        frequency_hz: natural frequency of an added servo with the joint's inertia at home.
        damping_ratio: of an added servo; 1 is critical damping.
        keeps: ``pose``: inverse kinematics hold place and orientation of the tip, for which six joints are
            needed; ``place``: the orientation is free.
        largest_step: of a joint's command in a frame, rad or m. At a wrist's singularity inverse kinematics
            would ask for whole turns.
    """

    actuators: Literal["added", "own", "weld"] = "added"
    frequency_hz: Annotated[float, Field(gt=0, le=100)] = 4.0
    damping_ratio: Annotated[float, Field(gt=0, le=10)] = 1.0
    keeps: Literal["pose", "place"] = "pose"
    largest_step: Annotated[float, Field(gt=0, le=100)] = 0.4

    @model_validator(mode="after")
    def _only_added_servos_are_tuned(self) -> Drive:
        given = [name for name in ("frequency_hz", "damping_ratio") if name in self.model_fields_set]
        if given and self.actuators != "added":
            raise ValueError(
                f"{' and '.join(given)} would change nothing with actuators: {self.actuators}; only added "
                "servos are tuned"
            )
        return self


class RobotParams(Section):
    """A robot.

    Attributes:
        file: MJCF or URDF below the folder ``robots/``, or ``PACKAGE:path/inside.xml`` in a Python package.
        build: ``attached`` for any file; the others know one file each, whose quirks they mend.
        remove: bodies of the file that are no part of the robot, such as a floor or a mocap handle.
        base: where it stands.
        tip: the point that reaches.
        home: positions of joints, or the name of one of the file's keyframes. A joint that is not named
            stands at 0, or in the middle of a range that lacks 0.
        drive: how the joints follow.
        hold: controls of actuators that move no joint of the arm; others keep the keyframe's, or 0.
        gravity: ``compensated``, as real arms' controllers do, or ``acts``.
    """

    file: Name
    build: Literal["attached", "kitchen_panda", "fetch_reach"] = "attached"
    remove: tuple[Name, ...] = ()
    base: Base = Base()
    tip: Tip
    home: dict[str, Position] | Name = Field(default_factory=dict)
    drive: Drive = Drive()
    hold: dict[str, Position] = Field(default_factory=dict)
    gravity: Literal["compensated", "acts"] = "compensated"

    @field_validator("home", mode="before")
    @classmethod
    def _map_or_name(cls, given: Any) -> Any:
        numbers = isinstance(given, dict) and all(type(value) in (int, float) for value in given.values())
        if not numbers and not isinstance(given, str):
            raise ValueError("it maps joints to positions (rad, m), or names a keyframe of the robot's file")
        return given

    @model_validator(mode="after")
    def _built_alike(self) -> RobotParams:
        own = {"attached": ("added", "own"), "kitchen_panda": ("own",), "fetch_reach": ("weld",)}[self.build]
        if self.drive.actuators not in own:
            raise ValueError(
                f"drive.actuators: {self.drive.actuators} is not for build: {self.build}, which takes "
                f"{' or '.join(own)}"
            )
        fixed = ("remove", "base", "hold", "gravity")
        if self.build != "attached" and (set(fixed) & self.model_fields_set or isinstance(self.home, str)):
            raise ValueError(f"{', '.join(fixed)} and a keyframe for home are not for build: {self.build}")
        return self


def robot_params(name: str, path: Path = params.PARAMS_FILE) -> RobotParams:
    """The robot called ``name``.

    Raises:
        BelvedereError: there is none of that name, which tells the known ones, or it is badly described.
    """
    declared = params.mapping("robots", path=path)
    if name not in declared:
        raise unknown("robot", name, declared)
    return params.section(RobotParams, "robots", name, path=path)
