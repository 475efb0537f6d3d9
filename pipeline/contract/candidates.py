"""The candidates of searches: a file that `./run search` writes, from which DVC makes their branches."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pydantic import Field

from pipeline.contract import params
from pipeline.contract.viewpoints import Viewpoint

CANDIDATES_FILE = Path("search/candidates.yaml")
FIRST_REPEATS = 1  # of a candidate; halving begins after one


class RuledOut(params.Section):
    """A place at which geometry alone says that no camera can stand, and why."""

    theta: float
    phi: float
    why: Annotated[str, Field(min_length=1)]


class Placed(params.Section):
    """The whole file.

    Attributes:
        candidates: by branch; its name is the scene's, a hyphen, c and a number.
        ruled_out: by scene, the places that were looked at and not taken.
    """

    candidates: dict[str, Viewpoint]
    ruled_out: dict[str, tuple[RuledOut, ...]]


def read_placed(path: Path = CANDIDATES_FILE) -> Placed:
    """The file's content; without a file nothing was ever searched.

    Raises:
        BelvedereError: the file holds no candidates.
    """
    return params.section(Placed, path=path) if path.is_file() else Placed(candidates={}, ruled_out={})


def searched_viewpoints(path: Path = CANDIDATES_FILE) -> dict[str, Viewpoint]:
    """The candidates of all scenes, by branch."""
    return read_placed(path).candidates


def ruled_out(scene: str, path: Path = CANDIDATES_FILE) -> list[dict[str, object]]:
    """Of a scene's places that geometry rules out θ and φ, degrees, and why."""
    return [one.model_dump() for one in read_placed(path).ruled_out.get(scene, ())]
