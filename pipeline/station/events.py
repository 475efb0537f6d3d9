"""What the course of a session hears of: of the page, and of the attempt at hand."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from pipeline.station.attempt import Attempt


@dataclass(frozen=True)
class Answered:
    """The participant went on from a page."""

    page: str
    values: Any


@dataclass(frozen=True)
class Pressed:
    """A button that the course hears of: ``pause`` or ``resume``."""

    name: str


@dataclass(frozen=True)
class Gone:
    """The page was closed."""


@dataclass(frozen=True, eq=False)
class Began:
    """An attempt had its first input."""

    attempt: Attempt


@dataclass(frozen=True, eq=False)
class Ended:
    """An attempt ended by itself."""

    attempt: Attempt


Event = Answered | Pressed | Gone | Began | Ended
