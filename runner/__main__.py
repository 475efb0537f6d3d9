"""`./run` and `./run --jobs N [TARGET …]`: the study, serially or with its branches side by side."""

from __future__ import annotations

import argparse
import os
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence

from pipeline.contract import scratch
from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE, cores
from runner.plan import branches, jobs, read_pipeline
from runner.schedule import Schedule
from runner.words import announcement, verdicts

THREADS_VARIABLE = "OMP_NUM_THREADS"  # what numerical libraries besides ours go by


def main(argv: Sequence[str]) -> int:
    """Runs what is asked for and returns the exit status."""
    asked = _parser().parse_args(argv)
    slots = None if asked.jobs is None else number_of_jobs(asked.jobs)
    if not asked.targets:
        print(announcement(), flush=True)
    if slots is not None:
        side_by_side(slots, asked.targets)
    status = repro(asked.targets)
    if status == 0 and not asked.targets:
        print(verdicts())
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="./run", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--jobs", nargs="?", const="", metavar="N", help="branches side by side")
    parser.add_argument("targets", nargs="*", metavar="TARGET", help="a stage, as for `dvc repro`")
    return parser


def number_of_jobs(given: str) -> int:
    """How many processes at once.

    Raises:
        BelvedereError: ``given`` is no whole number from 1 up.
    """
    if not (given.isascii() and given.isdigit()) or int(given) < 1:
        raise BelvedereError(
            f"--jobs {given!r} is not valid; it is a whole number from 1 up, as in ./run --jobs 2."
        )
    return int(given)


def shares(slots: int, environment: Mapping[str, str]) -> dict[str, str]:
    """The environment of one of ``slots`` processes: its share of the cores, unless the user gave it one."""
    share = str(cores() if CORES_VARIABLE in environment else max(1, cores() // slots))
    return {THREADS_VARIABLE: share, **environment, CORES_VARIABLE: share}


def side_by_side(slots: int, targets: Sequence[str]) -> None:
    """Runs what branches do alone, ``slots`` processes at once.

    Raises:
        BelvedereError: a job failed, or the scratch store cannot be written to.
    """
    environment, logs = shares(slots, os.environ), scratch.root() / "logs"
    to_do = jobs(read_pipeline(targets), branches())
    if not to_do:
        return
    try:
        logs.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BelvedereError(f"the logs' folder {logs} cannot be made ({error.strerror}).") from None
    print(
        f"{slots} at once, {environment[CORES_VARIABLE]} core(s) each; what they say is in {logs}", flush=True
    )
    Schedule(slots, environment, logs).run(to_do)


def repro(targets: Sequence[str]) -> int:
    """Runs `dvc repro` on this terminal and returns its status; an interrupt is DVC's to handle."""
    former = signal.signal(signal.SIGINT, lambda *_: None)  # a handler, unlike SIG_IGN, is not inherited
    try:
        return subprocess.run(["dvc", "repro", *targets]).returncode
    finally:
        signal.signal(signal.SIGINT, former)


def _heed_signals() -> None:
    """Makes a wish to end, or a closed terminal (unless nohup ignores it), as good as Ctrl-C."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler)


if __name__ == "__main__":
    _heed_signals()
    try:
        sys.exit(main(sys.argv[1:]))
    except BelvedereError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
