"""How many repeats each viewpoint has: a small file in git, which ``./run`` writes as the race goes on.

A branch's stage `frames` depends on the branch's own entry, and a scene's rollouts on the scene's, so that
one more repeat of one viewpoint recomputes nothing of the others.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import yaml
from pydantic import Field

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.storage.artefacts import writing

ALLOCATION_FILE = Path("data/allocation.yaml")
Count = Annotated[int, Field(ge=1, le=params.MOST_REPEATS)]

_HEAD = """\
# How many repeats (independent trainings) each viewpoint has. ./run writes it, round by round: a viewpoint
# that the race has put out gets no more. An entry counts for this budget, seed and viewpoint only; a branch
# without one that counts gets as many repeats as its scene.
"""


class Entry(Viewpoint):
    """A branch's viewpoint and its number of repeats."""

    repeats: Count


class Allocation(params.Section):
    """The whole file.

    Attributes:
        budget, seed: for which the numbers hold.
        scenes: the most repeats of any viewpoint of a scene.
        branches: each branch's own.
    """

    budget: str
    seed: int
    scenes: dict[str, Count]
    branches: dict[str, Entry]


def scene_repeats(scene: str, path: Path = ALLOCATION_FILE) -> int:
    """How many repeats the scene's random episodes are drawn for."""
    found = _current(path)
    return max(params.first_repeats(scene), found.scenes.get(scene, 1) if found else 1)


def branch_repeats(branch: str, view: Viewpoint, first: int, path: Path = ALLOCATION_FILE) -> int:
    """How many repeats a branch has, ``first`` at least; with another viewpoint as many as its scene."""
    found = _current(path)
    entry = found.branches.get(branch) if found else None
    if entry and entry.model_dump(exclude={"repeats"}) == view.model_dump():
        return max(first, entry.repeats)
    return scene_repeats(view.scene, path)


def read_allocation(path: Path = ALLOCATION_FILE) -> Allocation:
    """The file's content.

    Raises:
        BelvedereError: the file is missing, or holds no allocation.
    """
    if not path.is_file():
        raise BelvedereError(f"{path} is missing; `./run` writes it, or `git checkout {path}`.")
    return params.section(Allocation, path=path)


def write_allocation(allocation: Allocation, path: Path = ALLOCATION_FILE) -> None:
    """Writes the file whole, the same bytes for the same numbers."""
    tree = allocation.model_dump()
    for entry in tree["branches"].values():  # 30 rather than 30.0, as params.yaml has it
        entry |= {angle: _plain(entry[angle]) for angle in ("theta", "phi")}
    text = yaml.safe_dump(tree, sort_keys=False, default_flow_style=None, width=110)
    with writing(path) as aside:
        aside.write_text(_HEAD + text, encoding="utf-8")


def _current(path: Path) -> Allocation | None:
    """The file's content if it is for the budget and the seed of params.yaml."""
    found = read_allocation(path)
    return found if (found.budget, found.seed) == (params.budget(), params.seed()) else None


def _plain(angle_deg: float) -> float:
    return int(angle_deg) if angle_deg == int(angle_deg) else angle_deg
