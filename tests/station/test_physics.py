"""The thread that follows the clock: never ahead of it, one attempt at a time, each end told once."""

from __future__ import annotations

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from pipeline.station.attempt import Attempt
from pipeline.station.inputs import Mailbox, Taken
from pipeline.station.physics import Physics, Snapshot

FRAME_S = 0.01


class Counted:
    """An attempt that counts its frames, begins and ends at given ones, and may take its time."""

    def __init__(self, begins: int, ends: int, takes_s: float = 0.0) -> None:
        place = np.zeros(3)
        self.world = SimpleNamespace(tip=place, target=place, qpos=np.zeros(9), waypoint=lambda: place)
        self.frame, self.begun, self.aborted = 0, False, 0
        self.measured: object | None = None
        self._begins, self._ends, self._takes_s = begins, ends, takes_s

    def advance(self, taken: Taken, now_s: float) -> None:
        time.sleep(self._takes_s)
        self.frame += 1
        self.begun |= self.frame >= self._begins
        if self.frame >= self._ends and self.measured is None:
            self.measured = "ended"

    def abort(self, now_s: float) -> None:
        self.aborted += 1


class Watched:
    """A running thread and what it told."""

    def __init__(self) -> None:
        self.shown: list[Snapshot] = []
        self.began: list[Attempt] = []
        self.ended: list[Attempt] = []
        self.over = threading.Event()
        self.physics = Physics(Mailbox(), FRAME_S, self.shown.append, self.began.append, self._end)
        self.physics.start()

    def _end(self, attempt: Attempt) -> None:
        self.ended.append(attempt)
        self.over.set()

    def stop(self) -> None:
        self.physics.stop()
        self.physics.join()


@pytest.fixture
def watched() -> Watched:
    return Watched()


def test_begin_and_end_are_told_once_and_frames_are_counted_on(watched: Watched) -> None:
    for times in (1, 2):
        watched.over.clear()
        attempt = Counted(begins=3, ends=8)
        watched.physics.begin(attempt)  # type: ignore[arg-type]
        assert watched.over.wait(20)
        time.sleep(5 * FRAME_S)
        watched.physics.rest()
        assert len(watched.began) == len(watched.ended) == times
        assert attempt.aborted == 0 and attempt.frame >= 8
    watched.stop()
    assert [snapshot.frame for snapshot in watched.shown] == list(range(1, len(watched.shown) + 1))
    assert watched.physics.failure is None


def test_an_attempt_that_rests_is_broken_off_and_not_advanced(watched: Watched) -> None:
    attempt = Counted(begins=1, ends=10**9)
    watched.physics.begin(attempt)  # type: ignore[arg-type]
    while not watched.began:
        time.sleep(FRAME_S)
    watched.physics.rest()
    frames = attempt.frame
    time.sleep(10 * FRAME_S)
    watched.stop()
    assert attempt.frame == frames and attempt.aborted == 1 and not watched.ended


def test_one_that_had_no_input_is_none(watched: Watched) -> None:
    attempt = Counted(begins=10**9, ends=10**9)
    watched.physics.begin(attempt)  # type: ignore[arg-type]
    while attempt.frame < 3:
        time.sleep(FRAME_S)
    watched.physics.rest()
    watched.stop()
    assert attempt.aborted == 0


def test_simulated_time_does_not_overtake_the_clock(watched: Watched) -> None:
    attempt = Counted(begins=1, ends=10**9)
    begin_s = time.monotonic()
    watched.physics.begin(attempt)  # type: ignore[arg-type]
    time.sleep(1.0)
    watched.physics.rest()
    spent_s = time.monotonic() - begin_s
    watched.stop()
    assert 0 < attempt.frame <= spent_s / FRAME_S + 3


def test_a_simulation_that_is_too_slow_falls_behind_and_does_not_run_to_catch_up(watched: Watched) -> None:
    attempt = Counted(begins=1, ends=10**9, takes_s=5 * FRAME_S)
    begin_s = time.monotonic()
    watched.physics.begin(attempt)  # type: ignore[arg-type]
    time.sleep(0.5)
    attempt._takes_s = 0.0
    slow, slow_s = attempt.frame, time.monotonic() - begin_s
    time.sleep(0.5)
    watched.physics.rest()
    quick = attempt.frame - slow
    spent_s = time.monotonic() - begin_s - slow_s
    watched.stop()
    assert slow <= slow_s / (5 * FRAME_S) + 1
    assert quick <= spent_s / FRAME_S + 4  # what was lost stays lost


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_failure_is_kept_for_those_who_ask(watched: Watched) -> None:
    attempt = Counted(begins=1, ends=10**9)
    attempt.world.waypoint = None  # not callable
    watched.physics.begin(attempt)  # type: ignore[arg-type]
    watched.physics.join(20)
    assert isinstance(watched.physics.failure, TypeError)
