"""`./run python -m benchmarks.memory SCENE THETA PHI --repeats N [-S PATH=VALUE …]`: memory, stage by stage.

The stages of one viewpoint run as DVC runs them, each in a process of its own, in a temporary folder. The
table has the most memory that each held, as Linux counts it (``VmHWM``, MiB), beside a repeat's raw pictures.
``-S`` changes params.yaml as DVC's does.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from benchmarks.rows import Row
from benchmarks.sizes import changed, print_row
from benchmarks.training import ROOT, command, give_repeats, run_stage
from pipeline.contract.machine import cores

KEY = "memory"  # the branch's name
STAGES = ("rollouts", "frames", "geometry", "vae", "latents", "mdnrnn", "controller", "evaluation", "anchors")
TABLE = "most memory that a stage holds, MiB"
_PICTURE_BYTES = 64 * 64 * 3
_PEAK = "peak"  # the file in which a process leaves what it held, in KiB
# getrusage would also count what the process that started this one held
_TELLING = f"""
import atexit, pathlib, re, runpy, sys
def tell():
    held = re.search(r"VmHWM:\\s+(\\d+)", pathlib.Path("/proc/self/status").read_text())
    pathlib.Path("{_PEAK}").write_text(held[1])
atexit.register(tell)
del sys.argv[0]
runpy.run_module(sys.argv[0], run_name="__main__", alter_sys=True)
"""


def measured(view: dict[str, Any], repeats: int, stages: Sequence[str], changes: Sequence[str]) -> Row:
    """The row of ``view`` (scene, theta, phi), of so many repeats, with params.yaml changed."""
    tree = changed(yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8")), changes)
    with tempfile.TemporaryDirectory() as folder:
        give_repeats(Path(folder), tree, repeats)
        peaks = {stage: peak_mib(Path(folder), command(stage, KEY, view)) for stage in stages}
    scene, sizes = view["scene"], tree["budgets"][tree["budget"]]["rollouts"]
    episodes = sizes.get("scenes", {}).get(scene, sizes)["episodes"]
    raw = episodes * tree["scenes"][scene]["frames"] * _PICTURE_BYTES / 2**20
    said = {"table": TABLE, "scene": scene, "repeats": repeats, "episodes": episodes, "cores": cores()}
    return {**said, "raw pictures of a repeat": raw, **peaks}


def peak_mib(folder: Path, words: Sequence[str]) -> float:
    """The most memory that ``python WORDS``, ``-m MODULE …``, held, run in ``folder``.

    Raises:
        BelvedereError: it failed.
    """
    run_stage(folder, [sys.executable, "-c", _TELLING, *words[1:]])
    return int((folder / _PEAK).read_text(encoding="utf-8")) / 1024


def main(argv: Sequence[str] | None = None) -> None:
    """Prints the row as a table, or with ``--json`` as one object."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.memory", description=__doc__)
    parser.add_argument("--stages", nargs="+", choices=STAGES, default=STAGES, help="the first of them only")
    print_row(parser, lambda view, given: measured(view, given.repeats, given.stages, given.changes), argv)


if __name__ == "__main__":
    main()
