"""`./run bench [--json] [NAME…]`: speed as ratios against what one would run otherwise, within one run."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from importlib import import_module

from benchmarks.rows import Row, header, line, side_tables
from pipeline.contract.errors import BelvedereError, unknown
from pipeline.contract.machine import cores, processor

# Modules of this folder whose ``measure()`` gives a row or a list of rows; imported when their turn comes.
MODULES = (
    "render",
    "closed_loop",
    "plain",
    "vae",
    "cma_es",
    "training",
    "dqn",
    "growth",
    "device_loop",
    "dream",
    "station",
)


def main(argv: Sequence[str] | None = None) -> None:
    """Prints tables, or with ``--json`` one object a line, as each benchmark ends."""
    options = argparse.ArgumentParser(prog="./run bench", description=__doc__)
    options.add_argument("--json", action="store_true", help="one JSON object a line")
    options.add_argument("names", nargs="*", metavar="NAME", help=f"only these of {', '.join(MODULES)}")
    given = options.parse_args(argv)
    try:
        names = chosen(given.names)
        print(f"machine: {processor()}, {cores()} cores; other load spoils it", file=sys.stderr)
        run(names, given.json)
    except BelvedereError as error:
        print(f"error: {error}", file=sys.stderr)
        raise SystemExit(1) from None


def chosen(names: Sequence[str]) -> list[str]:
    """The benchmarks to run, in the order of :data:`MODULES`; none named is all.

    Raises:
        BelvedereError: a name is unknown.
    """
    for name in names:
        if name not in MODULES:
            raise unknown("benchmark", name, MODULES)
    return [name for name in MODULES if not names or name in names]


def run(names: Sequence[str], as_json: bool) -> None:
    """Runs benchmarks and prints their rows; small tables come after the goals."""
    if not as_json:
        print(header())
    later: list[Row] = []
    for name in names:
        found = import_module(f"benchmarks.{name}").measure()
        for row in found if isinstance(found, list) else [found]:
            if as_json:
                print(json.dumps(row, ensure_ascii=False), flush=True)
            elif "table" in row:
                later.append(row)
            else:
                print(line(row), flush=True)
    for text in side_tables(later):
        print(text)


if __name__ == "__main__":
    main()
