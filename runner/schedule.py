"""Jobs side by side, each in a process of DVC's, and their end when one fails or the user has had enough."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE, cores
from runner.interrupts import Interrupts
from runner.plan import Job

THREADS_VARIABLE = "OMP_NUM_THREADS"  # what numerical libraries besides ours go by
TAIL_LINES = 20  # of a failed job's log
_LOOK_EVERY_S = 0.1
_NVIDIA = Path("/dev/nvidiactl")  # there where CUDA is
DVC = (sys.executable, "-m", "runner.dvc")
# SIGINT lets stages and DVC clean up. What goes on regardless gets the next signal after so many seconds, or
# at another Ctrl-C.
_NICER = 5  # by which each place's processes are nicer than those of the place before
_NICEST = 15
_ENDINGS = ((signal.SIGINT, 10.0), (signal.SIGTERM, 5.0), (signal.SIGKILL, 5.0))


def default_jobs() -> int:
    """One viewpoint a core, or one alone where a GPU does the work and is filled by a viewpoint's repeats."""
    return 1 if _NVIDIA.exists() else cores()


def on_this_terminal(*words: str) -> int:
    """Runs `dvc` on this terminal and returns its status; an interrupt is DVC's to handle."""
    former = signal.signal(signal.SIGINT, lambda *_: None)  # a handler, unlike SIG_IGN, is not inherited
    try:
        return subprocess.run([*DVC, *words]).returncode
    finally:
        signal.signal(signal.SIGINT, former)


@dataclass(frozen=True)
class _Process:
    job: Job
    child: subprocess.Popen[bytes]
    log: Path
    begun_s: float


@dataclass
class Schedule:
    """Runs jobs, so many at once.

    A job of a lower place does not wait for one of a higher place: it begins beside it, as if that were not
    there, and the other, whose processes are nicer, has what time is left. So the first scene's answer does
    not wait for a training of the next scene that filled a gap.

    Attributes:
        slots: how many of a place, and of lower ones, at once.
        cores: what they share out among themselves; ``None`` where the user's own environment decides.
        environment: what the processes find in their environment besides.
        more: is told of each job that is done, and gives the jobs that have to be done now.
        logs: the folder that each process's output goes to, in a file of the job's name.
    """

    slots: int
    cores: int | None
    environment: Mapping[str, str]
    logs: Path
    more: Callable[[Job], Sequence[Job]]
    _running: list[_Process] = field(default_factory=list)
    _waiting: list[Job] = field(default_factory=list)
    _done: set[str] = field(default_factory=set)

    def run(self, jobs: Sequence[Job]) -> None:
        """Runs all jobs and those that come of them, each when what it waits for is done and a slot is free.

        Raises:
            BelvedereError: a job failed. None was begun after it; those at work were let finish.
            KeyboardInterrupt: the user wanted it to end, and all processes were ended.
        """
        with Interrupts() as interrupts:
            try:
                failed = self._run(jobs, interrupts)
            except BaseException:  # such as a closed pipe or a full disk: nobody would watch the processes
                self._end_all(interrupts)
                raise
        if interrupts.count:
            print("stopped; what is done stays done", flush=True)
            raise KeyboardInterrupt
        if failed:
            raise BelvedereError("\n".join(_failure_message(process) for process in failed))

    def _run(self, jobs: Sequence[Job], interrupts: Interrupts) -> list[_Process]:
        """Runs jobs until none is left, one fails or the user interrupts; returns the failed ones."""
        failed = list[_Process]()
        self._add(jobs)
        while True:
            while not failed and not interrupts.count and (ready := self._ready()):
                self._start(ready[0], len(ready))
            if not self._running:
                return failed
            ended = self._wait(interrupts)
            if not interrupts.count:
                failed += [process for process in ended if not self._succeeded(process)]

    def _add(self, jobs: Sequence[Job]) -> None:
        self._done -= {job.name for job in jobs}  # a branch has a job of its name in each round
        self._waiting = sorted([*self._waiting, *jobs], key=lambda job: job.place)

    def _ready(self) -> list[Job]:
        """The jobs that could begin, the first of them now."""
        return [job for job in self._waiting if job.after <= self._done and self._slot_for(job)]

    def _slot_for(self, job: Job) -> bool:
        return sum(process.job.place <= job.place for process in self._running) < self.slots

    def _start(self, job: Job, ready: int) -> None:
        self._waiting.remove(job)
        log = self.logs / f"{job.name}.log"
        with log.open("wb") as file:
            child = subprocess.Popen(
                # DVC takes the first option before the subcommand only
                [
                    "nice",
                    "-n",
                    str(min(_NICER * job.place, _NICEST)),
                    *DVC,
                    "--wait-for-lock",
                    "repro",
                    "--single-item",
                    *job.stages,
                ],
                env=self._share(ready),
                stdin=subprocess.DEVNULL,
                stdout=file,
                stderr=subprocess.STDOUT,
                process_group=0,  # so that it can be ended with all that it started
            )
        self._running.append(_Process(job, child, log, time.monotonic()))
        print(f"{job.name}: begun, {len(self._running)} at work", flush=True)

    def _share(self, ready: int) -> dict[str, str]:
        """The environment of a process that begins while ``ready`` jobs could: its share of the cores."""
        if self.cores is None:
            return dict(self.environment)
        beside = min(self.slots, len(self._running) + ready)
        share = str(max(1, self.cores // beside))
        return {THREADS_VARIABLE: share, **self.environment, CORES_VARIABLE: share}

    def _wait(self, interrupts: Interrupts) -> list[_Process]:
        """Waits until a process has ended, and takes those that have from the running ones."""
        while not (ended := [p for p in self._running if p.child.poll() is not None]):
            if interrupts.count:
                self._end_all(interrupts)
            time.sleep(_LOOK_EVERY_S)
        self._running = [p for p in self._running if p not in ended]
        return ended

    def _succeeded(self, process: _Process) -> bool:
        if process.child.returncode:
            at_work = ", ".join(p.job.name for p in self._running)
            print(f"{process.job.name}: failed" + (f"; waiting for {at_work}" if at_work else ""), flush=True)
            return False
        self._done.add(process.job.name)
        minutes, seconds = divmod(round(time.monotonic() - process.begun_s), 60)
        left = len(self._waiting) + len(self._running)
        print(f"{process.job.name}: done in {minutes}:{seconds:02} minutes, {left} to do", flush=True)
        self._add(self.more(process.job))
        return True

    def _end_all(self, interrupts: Interrupts) -> None:
        for number, patience_s in _ENDINGS:
            wishes, until = interrupts.count, time.monotonic() + patience_s
            for process in self._alive():
                os.killpg(process.child.pid, number)
            while self._alive() and time.monotonic() < until and interrupts.count == wishes:
                time.sleep(_LOOK_EVERY_S)

    def _alive(self) -> list[_Process]:
        return [p for p in self._running if p.child.poll() is None]


def _failure_message(process: _Process) -> str:
    lines = process.log.read_text(encoding="utf-8", errors="replace").splitlines()
    tail = "\n".join(f"    {line}" for line in lines[-TAIL_LINES:])
    return (
        f"{process.job.name} failed with status {process.child.returncode}; {process.log} ends with\n{tail}"
    )
