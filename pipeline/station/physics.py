"""The thread in which the simulation follows the clock, a control frame at a time."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pipeline.station.attempt import Attempt
from pipeline.station.inputs import Mailbox

_BEHIND = 2  # frames that are made up for; beyond that the simulation falls behind the clock, and says so


@dataclass(frozen=True, eq=False)
class Snapshot:
    """The world after a control frame, for a picture.

    Attributes:
        frame: number, over the whole session, from 1.
        seq: of the last applied input.
        simulated_ms: since the attempt began.
        qpos: shape (nq,). tip_m, target_m, waypoint_m: shape (3,), m.
    """

    frame: int
    seq: int
    simulated_ms: int
    qpos: np.ndarray
    tip_m: np.ndarray
    target_m: np.ndarray
    waypoint_m: np.ndarray


class Physics(threading.Thread):
    """Advances the attempt at hand, if there is one, 1 / ``frame_s`` times a second.

    A frame begins at its time by the clock with the newest input, and its state is shown at once: it is the
    state at the frame's end. Frames that come late are made up for, up to :data:`_BEHIND`; then time is lost,
    which the attempt's real-time factor tells.

    Args:
        mailbox: what the hands do.
        frame_s: length of a control frame.
        show: is given each frame's snapshot; must not wait.
        began: is told of an attempt's first input; must not wait.
        ended: is told of an attempt that has ended by itself; must not wait.
    """

    def __init__(
        self,
        mailbox: Mailbox,
        frame_s: float,
        show: Callable[[Snapshot], None],
        began: Callable[[Attempt], None],
        ended: Callable[[Attempt], None],
    ) -> None:
        super().__init__(name="physics", daemon=True)
        self.failure: BaseException | None = None
        self._mailbox, self.frame_s = mailbox, frame_s
        self._show, self._began, self._ended = show, began, ended
        self._lock = threading.Lock()
        self._attempt: Attempt | None = None
        self.frames, self._stops = 0, threading.Event()

    def begin(self, attempt: Attempt) -> None:
        """From now on this attempt is advanced."""
        self._mailbox.clear()
        with self._lock:
            self._attempt = attempt

    def rest(self) -> None:
        """No attempt is advanced from now on; one that had begun and not ended is broken off."""
        with self._lock:
            attempt, self._attempt = self._attempt, None
            if attempt is not None and attempt.measured is None and attempt.begun:
                attempt.abort(time.monotonic())

    def stop(self) -> None:
        """Ends the thread."""
        self._stops.set()

    def run(self) -> None:
        try:
            self._run()
        except BaseException as error:
            self.failure = error
            raise

    def _run(self) -> None:
        due_s = time.monotonic()
        while not self._stops.is_set():
            due_s += self.frame_s
            wait_s = due_s - time.monotonic()
            if wait_s > 0:
                self._stops.wait(wait_s)
            elif -wait_s > _BEHIND * self.frame_s:
                due_s = time.monotonic()
            with self._lock:
                self._advance()

    def _advance(self) -> None:
        attempt, now_s = self._attempt, time.monotonic()
        if attempt is None:
            return
        taken = self._mailbox.take(now_s)
        over, begun = attempt.measured is not None, attempt.begun
        attempt.advance(taken, now_s)
        self.frames += 1
        world = attempt.world
        milliseconds = round(attempt.frame * self.frame_s * 1000)
        places = world.tip, world.target, world.waypoint()
        self._show(Snapshot(self.frames, taken.now.seq, milliseconds, world.qpos, *places))
        if attempt.begun and not begun:
            self._began(attempt)
        if attempt.measured is not None and not over:
            self._ended(attempt)
