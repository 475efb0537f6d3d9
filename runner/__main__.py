"""`./run [--jobs N] [SCENE …]`: the race of each scene's viewpoints, until every scene has its answer."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Sequence

from pipeline.contract import params
from pipeline.contract.declared import branches, check_viewpoints
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.machine import CORES_VARIABLE, cores
from pipeline.storage import scratch
from runner import ablation, search
from runner.dvc import read_faster
from runner.lock import check_lock
from runner.messages import announcement, answers
from runner.parameters import check_parameters
from runner.plan import read_pipeline
from runner.race import Race, allocate, soonest_answered
from runner.rwlock import drop_damaged_rwlock
from runner.schedule import Schedule, default_jobs, on_this_terminal


def main(argv: Sequence[str]) -> int:
    """Runs what is asked for and returns the exit status."""
    for name, command in (("search", search.main), ("ablation", ablation.main)):
        if argv[:1] == [name]:
            return command(argv[1:])
    asked = _parser().parse_args(argv)
    check_parameters()
    check_lock()
    slots = default_jobs() if asked.jobs is None else number_of_jobs(asked.jobs)
    for scene in asked.scenes:
        if scene not in params.value("scenes"):
            raise unknown("scene", scene, params.value("scenes"))
    check_viewpoints()
    print(announcement(asked.scenes), flush=True)
    race(slots, asked.scenes)
    if asked.scenes:
        return 0
    status = on_this_terminal("repro")
    if status == 0:
        print(answers())
    return status


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="./run", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--jobs", metavar="N", nargs="?", const="", help="viewpoints at work at a time")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="of params.yaml; without any, all")
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


def race(slots: int, scenes: Sequence[str]) -> None:
    """Runs rounds until each of the scenes (all, where there are none) has its answer.

    Raises:
        BelvedereError: a stage failed, or the scratch store cannot be written to.
    """
    read_faster()
    drop_damaged_rwlock()
    allocation, logs = allocate(), scratch.root() / "logs"
    ordered = list(dict.fromkeys(scenes)) or soonest_answered(allocation)
    pipeline = read_pipeline([f"ranking@{scene}" for scene in ordered])
    race = Race(pipeline, branches(), ordered, cores(), allocation)
    to_do = race.begin()
    if not to_do:
        return
    try:
        logs.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BelvedereError(f"the logs' folder {logs} cannot be made ({error.strerror}).") from None
    print(f"{slots} at once on {cores()} core(s); what they say is in {logs}", flush=True)
    shared = None if CORES_VARIABLE in os.environ else cores()
    Schedule(slots, shared, os.environ, logs, race.more).run(to_do)


def _handle_signals() -> None:
    """Makes a wish to end, or a closed terminal (unless nohup ignores it), as good as Ctrl-C."""
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, signal.default_int_handler)


if __name__ == "__main__":
    _handle_signals()
    try:
        sys.exit(main(sys.argv[1:]))
    except BelvedereError as error:
        print(f"error: {error}", file=sys.stderr)
        sys.exit(1)
    except KeyboardInterrupt:
        sys.exit(130)
