"""A stage's entry: flags from the signature of ``main``, one sentence for bad input.

A stage is a script with ``def main(*, scene: str, theta: float, out: Path) -> None`` and, below,
``if __name__ == "__main__": entry(main)``. Every parameter becomes a required flag.
"""

from __future__ import annotations

import argparse
import gc
import inspect
import os
import sys
import threading
import time
import traceback
import typing
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NoReturn

from pipeline.contract.errors import BelvedereError
from pipeline.contract.lifetime import STAGE_VARIABLE
from pipeline.contract.machine import cores, processor
from pipeline.storage import scratch
from pipeline.storage.artefacts import write_json
from pipeline.storage.disks import cache_sentence, unwritable

WORKER = "worker"  # what the names of threads begin with for which an ending process must not wait


def entry(main: Callable[..., None], argv: Sequence[str] | None = None) -> None:
    """Runs a stage's ``main`` with the command line's flags.

    Flags are the keyword parameters of ``main``: ``str``, ``int``, ``float``, ``Path`` or, where a
    flag may be given several values, ``list[str]`` / ``list[Path]``; one with a default is optional.
    """
    _line_buffer()
    gc.freeze()  # libraries' objects live to the end: to walk through them takes 2 s at exit alone
    begun, before = time.monotonic(), frozenset(threading.enumerate())
    try:
        main(**vars(parser(main).parse_args(argv)))
        _record_seconds(time.monotonic() - begun)
    except BelvedereError as error:
        print(f"error: {error}", file=sys.stderr)
        _leave(1, before)
    except KeyboardInterrupt:
        _leave(130, before)
    except Exception as error:
        reason = unwritable(error)
        if reason:
            print(f"error: {cache_sentence(error, reason)}", file=sys.stderr)
            _leave(1, before)
        if not _others_work(before):
            raise
        traceback.print_exc()
        _leave(1, before)


def _leave(status: int, before: frozenset[threading.Thread]) -> NoReturn:
    """Ends the process, at once if others are at work: an ordinary exit would wait for their threads."""
    if _others_work(before):
        sys.stdout.flush()
        os._exit(status)
    raise SystemExit(status) from None


def _others_work(before: frozenset[threading.Thread]) -> bool:
    """Whether ``main`` has begun workers that are not done; those that were there before are not its own."""
    return any(thread.name.startswith(WORKER) for thread in threading.enumerate() if thread not in before)


class _Parser(argparse.ArgumentParser):
    """A parser that tells what is wrong in one sentence."""

    def error(self, message: str) -> NoReturn:
        raise BelvedereError(f"{message}; `--help` lists the flags and what they take.")


def parser(main: Callable[..., None]) -> argparse.ArgumentParser:
    """The argument parser that :func:`entry` uses."""
    doc = inspect.getdoc(inspect.getmodule(main)) or ""
    result = _Parser(description=doc.splitlines()[0] if doc else None)
    hints = typing.get_type_hints(main)
    for name, parameter in inspect.signature(main).parameters.items():
        kind = hints[name]
        several = typing.get_origin(kind) is list
        convert = typing.get_args(kind)[0] if several else kind
        required = parameter.default is inspect.Parameter.empty
        result.add_argument(
            f"--{name.replace('_', '-')}",
            dest=name,
            required=required,
            default=None if required else parameter.default,
            type=convert if convert in (int, float, Path) else str,
            nargs="+" if several else None,
        )
    return result


def _record_seconds(seconds: float) -> None:
    """Keeps what a stage took, for the report; in the scratch store, since outputs must not vary.

    A stage that is done does not fail for want of this record, which the report can do without.
    """
    stage = os.environ.get(STAGE_VARIABLE)
    if stage:
        record = {"stage": stage, "seconds": round(seconds, 1), "machine": processor(), "cores": cores()}
        try:
            write_json(scratch.root() / "seconds" / f"{stage}.json", record)
        except (BelvedereError, OSError) as error:
            print(f"warning: the seconds of {stage} are not recorded: {error}", file=sys.stderr)


def _line_buffer() -> None:
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(line_buffering=True)
