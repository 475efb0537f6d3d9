"""What the participant's hands do, between the connection that hears of it and the physics that asks."""

from __future__ import annotations

import threading
from dataclasses import dataclass, field

import numpy as np

SILENCE_S = 0.5  # after so long without a word the sticks count as let go


def _still() -> np.ndarray:
    return np.zeros(2)


@dataclass(frozen=True, eq=False)
class Push:
    """One reading of the sticks.

    Attributes:
        seq: the page's number of it, from 1; 0 before there is one.
        at_s: when it was received, on the monotonic clock.
        left, right: shape (2,), as the Gamepad API gives them.
        source: ``gamepad`` or ``keyboard``.
        device: the browser's name of it.
    """

    seq: int = 0
    at_s: float = float("-inf")
    left: np.ndarray = field(default_factory=_still)
    right: np.ndarray = field(default_factory=_still)
    source: str = ""
    device: str = ""


@dataclass(frozen=True, eq=False)
class Taken:
    """What came since the last control frame.

    Attributes:
        pushes: readings, oldest first.
        now: the newest of all; its sticks are let go where nothing came for :data:`SILENCE_S`.
        buttons: names with the times at which they were received, oldest first.
    """

    pushes: tuple[Push, ...]
    now: Push
    buttons: tuple[tuple[str, float], ...]


class Mailbox:
    """Filled by the connection, emptied by the physics once a control frame; for threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._pushes: list[Push] = []
        self._buttons: list[tuple[str, float]] = []
        self._last = Push()

    def push(self, push: Push) -> None:
        """A new reading of the sticks."""
        with self._lock:
            self._pushes.append(push)

    def button(self, name: str, at_s: float) -> None:
        """A button went down."""
        with self._lock:
            self._buttons.append((name, at_s))

    def clear(self) -> None:
        """Forgets what nobody took, and that sticks were pushed."""
        with self._lock:
            self._pushes, self._buttons = [], []
            self._last = Push(seq=self._last.seq)

    def take(self, now_s: float) -> Taken:
        """All that came since the last call."""
        with self._lock:
            pushes, buttons = tuple(self._pushes), tuple(self._buttons)
            self._pushes, self._buttons = [], []
            self._last = pushes[-1] if pushes else self._last
            last = self._last
        if now_s - last.at_s > SILENCE_S:
            last = Push(last.seq, last.at_s, source=last.source, device=last.device)
        return Taken(pushes, last, buttons)
