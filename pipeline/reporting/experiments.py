"""DVC's experiments: which ended with success, and whether a result is of the revision that it lies in.

An experiment that is queued, at work or failed has a revision, too, in which the baseline's results lie.
"""

from __future__ import annotations

import subprocess
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

import dvc.api
from dvc.dependency import ParamsDependency
from dvc.repo import Repo

# DVC gives no state to those that did not go through its queue: run in the workspace or with --temp, saved,
# or pulled. It names these only once they ended with success.
_ENDED = (None, "Success")
_ABSENT = {"deleted", "not in cache"}


@dataclass(frozen=True)
class Experiment:
    """An experiment that began from the current commit.

    Attributes:
        name: DVC's.
        revision: the commit.
        unfinished: DVC's word for one that did not end with success: queued, running, failed.
    """

    name: str
    revision: str
    unfinished: str | None


def experiments() -> Iterator[Experiment]:
    """All experiments that began from the current commit, whatever became of them."""
    for row in dvc.api.exp_show():
        if row.get("Experiment"):
            state = row.get("State")
            left = None if state in _ENDED else str(state).lower()
            yield Experiment(str(row["Experiment"]), str(row["rev"]), left)


def stale(target: str, revision: str | None = None) -> str | None:
    """The first stage behind a result that is not as the dvc.lock beside it says; ``None`` if all are.

    Args:
        target: DVC's name of the stage that made the result.
        revision: a commit; without one, the working tree. Absent data are taken to be what dvc.lock says.
    """
    with Repo(rev=revision) as repo:
        behind = repo.stage.collect(target, with_deps=True)
        made = {out.fs_path: out.hash_info for stage in behind for out in stage.outs}
        return next((stage.name for stage in behind if _changed(stage, made)), None)


def other_code(target: str, revision: str) -> list[str]:
    """The files that a commit's result was made by and that are not the same in the working tree."""
    with Repo(rev=revision) as repo:
        behind = repo.stage.collect(target, with_deps=True)
        made = {out.fs_path for stage in behind for out in stage.outs}
        files = [d for s in behind for d in s.deps if not isinstance(d, ParamsDependency)]
        code = sorted({str(dep.def_path) for dep in files if dep.fs_path not in made})
    words = ("git", "diff", "--name-only", revision, "--", *code)
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.split("\n")[:-1]


def _changed(stage: Any, made: dict[str, Any]) -> bool:
    if stage.changed_stage():
        return True
    for dep in stage.deps:
        status = dep.status()
        if isinstance(dep, ParamsDependency):
            if status:
                return True
        elif _differs(status.values()) or made.get(dep.fs_path, dep.hash_info) != dep.hash_info:
            return True
    return any(_differs(out.status().values()) for out in stage.outs)


def _differs(states: Collection[str]) -> bool:
    return bool(set(states) - _ABSENT)
