"""Repeats in processes: their results in order, a failure as it is, a killed process in a sentence."""

from __future__ import annotations

import os
import signal
import time
from functools import partial
from multiprocessing import active_children

import pytest

from pipeline.contract.errors import BelvedereError, unknown
from pipeline.learning.side_by_side import in_processes


@pytest.fixture(autouse=True)
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BELVEDERE_CORES", "2")


def make(number: int, repeat: int) -> int:
    """Repeat 1 gets signal ``number``, if there is one, while the others are at work."""
    if number and repeat == 1:
        os.kill(os.getpid(), number)
    time.sleep(0.2)
    return 10 * repeat


def refuse(repeat: int) -> int:
    raise unknown("repeat", repeat, [7])


def test_results_come_in_order() -> None:
    assert in_processes(partial(make, 0), 3) == [0, 10, 20]


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_killed_process_is_told_in_a_sentence(number: int) -> None:
    with pytest.raises(BelvedereError) as told:
        in_processes(partial(make, number), 3)
    assert str(told.value) == (
        "a process at work on one of 3 repeats, 2 at a time was killed from outside, as systems do that run "
        "out of memory; finished repeats are kept: run it again, with BELVEDERE_CORES=1 if memory is short."
    )
    assert told.value.__suppress_context__ and not active_children()


def test_what_a_process_refuses_is_what_is_told() -> None:
    with pytest.raises(BelvedereError, match=r"repeat '\d' is unknown; available: 7"):
        in_processes(refuse, 2)
