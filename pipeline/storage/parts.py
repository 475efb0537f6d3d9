"""Large arrays some episodes at a time, so that none is in memory whole."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class InParts:
    """An array that is made as it is written.

    Attributes:
        shape: of all of it, ``(episode, …)``.
        make: is called with consecutive slices of episodes, from the first on, for their part of it.
    """

    shape: tuple[int, ...]
    make: Callable[[slice], np.ndarray]


def places(count: int, size: int) -> Iterator[slice]:
    """Consecutive slices of at most ``size`` that cover ``count``."""
    return (slice(begin, min(begin + size, count)) for begin in range(0, count, size))


def parts(array: np.ndarray | InParts, size: int) -> Iterator[tuple[slice, np.ndarray]]:
    """The parts of an array, ``size`` episodes each (the last may have fewer), with their places."""
    for place in places(array.shape[0], size):
        yield place, array.make(place) if isinstance(array, InParts) else array[place]
