"""`./run bench [--json]`: speed as ratios against what one would run otherwise, each within one run."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from benchmarks import closed_loop, dqn, render, vae
from pipeline.contract.machine import cores, processor

BENCHMARKS = (render.measure, closed_loop.measure, vae.measure, dqn.measure)
HEADER = ("work", "scene", "ours", "peer", "unit", "ratio", "goal", "holds")


def main() -> None:
    """Prints a table, or with ``--json`` one object a line, as each benchmark ends."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--json", action="store_true", help="one JSON object a line")
    as_json = options.parse_args().json
    print(f"machine: {processor()}, {cores()} cores; other load spoils it", file=sys.stderr)
    if not as_json:
        print("{:<28} {:<22} {:>10} {:>10} {:<12} {:>7} {:>6} {}".format(*HEADER))
    for measure in BENCHMARKS:
        found = measure()
        for row in found if isinstance(found, list) else [found]:
            print(json.dumps(row) if as_json else line(row), flush=True)


def line(row: dict[str, Any]) -> str:
    """One row of the table; dashes where no goal is set."""
    goal = "–" if row["goal"] is None else f"{row['goal']:.2f}"
    holds = {None: "–", True: "yes", False: "no"}[row["holds"]]
    return (
        f"{row['work']:<28} {row['scene']:<22} {row['ours']:>10.0f} {row['peer']:>10.0f} {row['unit']:<12} "
        f"{row['ratio']:>7.2f} {goal:>6} {holds}"
    )


if __name__ == "__main__":
    main()
