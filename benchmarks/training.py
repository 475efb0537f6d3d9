"""One training at the quick budget: the real stages of one branch, in a temporary folder.

As many repeats as there are cores, two at least, since they train side by side, and their time shared out.
They bear the starts of all stages by themselves, so it bounds from above what a training costs among more.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import yaml

from benchmarks.rows import AT_MOST, Row, goal_row
from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import cores
from pipeline.storage.allocation import ALLOCATION_FILE, Allocation, write_allocation

ROOT = Path(__file__).resolve().parents[1]
BRANCH = "panda_2dof-a"
GOAL_S = 80.0
STAGES = ("frames", "vae", "latents", "mdnrnn", "controller", "evaluation")
TABLE = "one training, quick budget, by stage"


def measure() -> list[Row]:
    """The training's row, and its stages' seconds as a table; rollouts, the scene's, do not count."""
    repeats = max(2, cores())
    with tempfile.TemporaryDirectory() as folder:
        seconds = {stage: s / repeats for stage, s in trained(Path(folder), "quick", repeats).items()}
    whole, scene = sum(seconds.values()), _view()["scene"]
    work = f"one training, quick budget, one of {repeats}"
    goal = goal_row(work, scene, whole, None, "s", None, GOAL_S, AT_MOST)
    return [goal, {"table": TABLE, "branch": BRANCH, "unit": "s", **seconds, "all": whole}]


def trained(folder: Path, budget: str, repeats: int) -> dict[str, float]:
    """Trains the branch ``repeats`` times in ``folder``, from nothing; seconds by stage.

    Raises:
        BelvedereError: a stage failed.
    """
    tree = _read("params.yaml")
    tree["budget"] = budget
    give_repeats(folder, tree, repeats)
    view = _view()
    run_stage(folder, [sys.executable, *command("rollouts", BRANCH, view)])
    seconds = {}
    for stage in STAGES:
        begin = time.perf_counter()
        run_stage(folder, [sys.executable, *command(stage, BRANCH, view)])
        seconds[stage] = time.perf_counter() - begin
    return seconds


def give_repeats(folder: Path, tree: dict[str, Any], repeats: int) -> None:
    """Writes parameters ``tree`` into ``folder``, where a branch then has so many repeats, two at least."""
    budget = tree["budget"]
    tree["budgets"][budget]["race"] = {"first": repeats, "most": repeats}
    (folder / "params.yaml").write_text(yaml.safe_dump(tree, sort_keys=False), encoding="utf-8")
    # no number is allocated, so each has the first
    nothing = Allocation(budget=budget, seed=tree["seed"], scenes={}, branches={})
    write_allocation(nothing, folder / ALLOCATION_FILE)


def command(stage: str, branch: str, view: dict[str, Any]) -> list[str]:
    """The words that stand behind ``python`` in the stage's command for a branch, as dvc.yaml has it."""
    # a stage of a scene is given the scene's name, one of a branch its key and its viewpoint
    form = _read("dvc.yaml")["stages"][stage]
    values: dict[str, Any] = {f"item.{name}": value for name, value in view.items()}
    values["key"] = view["scene"] if form["foreach"] == "${scenes}" else branch
    filled = re.sub(r"\$\{([^}]+)\}", lambda found: str(values[found[1]]), form["do"]["cmd"])
    program, *arguments = shlex.split(filled)
    if program != "python":
        raise ValueError(f"stage {stage} starts {program}")
    return arguments


def run_stage(folder: Path, words: list[str]) -> None:
    """Runs a command in ``folder``, on this working tree's code, to its end.

    Raises:
        BelvedereError: it failed.
    """
    kept = {name: value for name, value in os.environ.items() if not name.startswith("DVC_")}
    place = {"PYTHONPATH": str(ROOT), "BELVEDERE_SCRATCH": str(folder / ".scratch")}
    done = subprocess.run(words, cwd=folder, env=kept | place, capture_output=True, text=True)
    if done.returncode:
        told = done.stderr.strip().splitlines() or ["it says nothing"]
        raise BelvedereError(f"`{shlex.join(words[1:])}` ended with status {done.returncode}: {told[-1]}")


def _view() -> dict[str, Any]:
    return dict(_read("params.yaml")["viewpoints"][BRANCH])


def _read(name: str) -> Any:
    return yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))
