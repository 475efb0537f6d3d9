"""What page and station say to each other: JSON as text, pictures as binary (docs/station.md)."""

from __future__ import annotations

import json
import struct
from typing import Annotated, Any, Literal

from pydantic import Field, TypeAdapter, ValidationError

from pipeline.contract.params import Section

PROTOCOL = 1
MOST_BYTES = 4096  # of a message from the page
JPEG = 1
_HEADER = struct.Struct("<IIII")

Stick = tuple[Annotated[float, Field(ge=-1, le=1)], Annotated[float, Field(ge=-1, le=1)]]
Number = Annotated[int, Field(ge=0, lt=2**32)]
PageName = Annotated[str, Field(pattern=r"^[a-z]{1,20}$")]


class Malformed(Exception):
    """A message that is none of the protocol; its text says why."""


class Hello(Section):
    """The page is there."""

    type: Literal["hello"]
    protocol: int


class Input(Section):
    """A reading of the sticks, as the Gamepad API gives them."""

    type: Literal["input"]
    seq: Number
    left: Stick
    right: Stick
    source: Literal["gamepad", "keyboard"]
    device: Annotated[str, Field(max_length=200)]


class Button(Section):
    """A button went down."""

    type: Literal["button"]
    name: Literal["a", "start", "pause", "resume"]


class Drawn(Section):
    """A picture was drawn, so long after the input ``seq`` in its header was read (None: not a new one)."""

    type: Literal["drawn"]
    frame: Number
    latency_ms: Annotated[float, Field(ge=0, le=60_000)] | None


class Answer(Section):
    """The participant goes on from a page."""

    type: Literal["answer"]
    page: PageName
    values: dict[Annotated[str, Field(max_length=40)], Any]


class ConsentValues(Section):
    """Whether the participant agrees, and to which version of the text."""

    accepted: bool
    version: Annotated[str, Field(max_length=40)]


class GamepadValues(Section):
    """What the test of the gamepad found."""

    source: Literal["gamepad", "keyboard"]
    device: Annotated[str, Field(max_length=200)]
    mapping: Annotated[str, Field(max_length=40)]
    drift: Annotated[float, Field(ge=0, le=2)]
    window: tuple[Number, Number]
    pixel_ratio: Annotated[float, Field(gt=0, le=100)]


Scale = Annotated[int, Field(ge=0, le=100)]


class TlxValues(Section):
    """NASA-TLX, unweighted."""

    mental: Scale
    physical: Scale
    temporal: Scale
    performance: Scale
    effort: Scale
    frustration: Scale


class NoValues(Section):
    """A page on which there is nothing to say but that one goes on."""


_VALUES: dict[str, type[Section]] = {"consent": ConsentValues, "gamepad": GamepadValues, "tlx": TlxValues}

AnyMessage = Annotated[Hello | Input | Button | Drawn | Answer, Field(discriminator="type")]
_MESSAGE: TypeAdapter[Hello | Input | Button | Drawn | Answer] = TypeAdapter(AnyMessage)


def parsed(text: str) -> Hello | Input | Button | Drawn | Answer:
    """A message of the page.

    Raises:
        Malformed: it is none.
    """
    try:
        return _MESSAGE.validate_json(text, strict=True)
    except (ValidationError, RecursionError) as error:
        first = error.errors()[0]["msg"] if isinstance(error, ValidationError) else "too deep"
        raise Malformed(first) from None


def checked_values(answer: Answer) -> Section:
    """An answer's values.

    Raises:
        Malformed: they are not those of its page.
    """
    try:
        return _VALUES.get(answer.page, NoValues).model_validate_json(json.dumps(answer.values), strict=True)
    except ValidationError as error:
        raise Malformed(error.errors()[0]["msg"]) from None


def picture_message(frame: int, seq: int, simulated_ms: int, jpeg: bytes) -> bytes:
    """A picture with its header of 16 bytes."""
    return _HEADER.pack(frame % 2**32, seq % 2**32, simulated_ms % 2**32, JPEG) + jpeg


def picture_header(message: bytes) -> tuple[int, int, int, int]:
    """Frame, seq, simulated milliseconds and format of a picture's message."""
    frame, seq, simulated_ms, kind = _HEADER.unpack_from(message)
    return frame, seq, simulated_ms, kind
