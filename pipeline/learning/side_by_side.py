"""A branch's repeats side by side, in threads or in processes (no torch here)."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, ThreadPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from typing import TypeVar

from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE, cores
from pipeline.storage.stage import WORKER

Result = TypeVar("Result")

_LOOK_EVERY_S = 0.5


def at_a_time(repeats: int) -> int:
    """How many of so many repeats are made at a time."""
    return min(repeats, cores())


def side_by_side(make: Callable[[int], Result], repeats: int) -> list[Result]:
    """``make(repeat)`` of each repeat, as many at a time as there are cores, each in one thread.

    Networks this small gain little from a second thread and repeats need nothing of each other; torch
    releases the interpreter's lock in its operations.
    """
    pool = ThreadPoolExecutor(at_a_time(repeats), WORKER)
    try:
        return _results([pool.submit(make, repeat) for repeat in range(repeats)])
    finally:  # after a failure or Ctrl-C nobody waits for the others
        pool.shutdown(wait=False, cancel_futures=True)


def _results(futures: Sequence[Future[Result]]) -> list[Result]:
    """The futures' results, or what the first to fail raises, as soon as it does."""
    pending = set(futures)
    while pending:  # in short waits, as a Ctrl-C that comes just before one begins would not end it
        done, pending = wait(pending, _LOOK_EVERY_S, FIRST_EXCEPTION)
        for future in done:
            future.result()
    return [future.result() for future in futures]


def in_processes(make: Callable[[int], Result], repeats: int) -> list[Result]:
    """The same, each repeat in a process of its own: for what draws from generators that a process shares.

    ``make`` and its results go through pickle. One repeat at a time needs no other process.

    Raises:
        BelvedereError: a process was killed from outside.
    """
    workers = at_a_time(repeats)
    if workers <= 1:
        return [make(repeat) for repeat in range(repeats)]
    share = max(1, cores() // workers)
    pool = ProcessPoolExecutor(workers, get_context("spawn"), _begin_process, (share,))
    with killed_is_told(f"one of {repeats} repeats, {workers} at a time"), pool:
        try:
            return _results([pool.submit(make, repeat) for repeat in range(repeats)])
        except BaseException:
            for process in active_children():  # or the pool would wait for them
                process.terminate()
            raise


@contextmanager
def killed_is_told(work: str) -> Iterator[None]:
    """Within it the death of a process that does some of ``work`` is told in a sentence.

    Raises:
        BelvedereError: a process was killed from outside.
    """
    try:
        yield
    except (BrokenProcessPool, EOFError, BrokenPipeError):  # the last two from pipes to processes of our own
        raise BelvedereError(
            f"a process at work on {work} was killed from outside, as systems do that run out of memory; "
            f"finished repeats are kept: run it again, with {CORES_VARIABLE}=1 if memory is short."
        ) from None


def _begin_process(share: int) -> None:
    """Runs first in each process of :func:`in_processes`."""
    os.environ[CORES_VARIABLE] = str(share)
