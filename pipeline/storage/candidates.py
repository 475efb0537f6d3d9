"""Candidates and finalists of searches: files that `./run search` writes, whose stages DVC then makes."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import yaml
from pydantic import Field

from pipeline.contract import params
from pipeline.contract.viewpoints import Viewpoint
from pipeline.storage.artefacts import writing

CANDIDATES_FILE = Path("search/candidates.yaml")
FINALISTS_FILE = Path("search/finalists.yaml")
FIRST_REPEATS = 1  # of a candidate; halving begins after one
_HEADS = {
    CANDIDATES_FILE.name: """\
# The candidates of searches, which `./run search SCENE` places as `searches` in params.yaml says, and the
# places that geometry rules out. DVC makes a branch of each candidate (search/dvc.yaml).
""",
    FINALISTS_FILE.name: """\
# The finalists of searches, written by `./run search` once they are known: DVC tries each off its place.
""",
}


class Candidate(Viewpoint):
    """A viewpoint with a camera of its own: its distance from what it looks at, and its field of view."""

    distance_m: Annotated[float, Field(gt=0)]
    fov_deg: Annotated[float, Field(gt=0, lt=170)]

    @property
    def viewpoint(self) -> Viewpoint:
        """Where it stands, whatever its camera."""
        return Viewpoint(scene=self.scene, theta=self.theta, phi=self.phi)


class RuledOut(params.Section):
    """A place at which geometry alone says that no camera can stand, and why."""

    theta: float
    phi: float
    distance_m: float
    fov_deg: float
    why: Annotated[str, Field(min_length=1)]


class Placed(params.Section):
    """The whole file.

    Attributes:
        candidates: by branch; its name is the scene's, a hyphen, c and a number.
        ruled_out: by scene, the places that were looked at and not taken.
    """

    candidates: dict[str, Candidate]
    ruled_out: dict[str, tuple[RuledOut, ...]]


def read_placed(path: Path = CANDIDATES_FILE) -> Placed:
    """The file's content; without a file nothing was ever searched.

    Raises:
        BelvedereError: the file holds no candidates.
    """
    return params.section(Placed, path=path) if path.is_file() else Placed(candidates={}, ruled_out={})


def searched_viewpoints(path: Path = CANDIDATES_FILE) -> dict[str, Viewpoint]:
    """Where the candidates of all scenes stand, by branch."""
    return {key: one.viewpoint for key, one in read_placed(path).candidates.items()}


def candidates_of(scene: str, path: Path = CANDIDATES_FILE) -> dict[str, Candidate]:
    """The candidates of a scene, by branch."""
    return {key: one for key, one in read_placed(path).candidates.items() if one.scene == scene}


def ruled_out(scene: str, path: Path = CANDIDATES_FILE) -> list[dict[str, object]]:
    """Of a scene's places that geometry rules out where they are, and why."""
    return [one.model_dump() for one in read_placed(path).ruled_out.get(scene, ())]


class Finalists(params.Section):
    """The whole file of finalists, by branch."""

    finalists: dict[str, Candidate]


def read_finalists(path: Path = FINALISTS_FILE) -> dict[str, Candidate]:
    """The finalists of all scenes; none where no search has ended."""
    return params.section(Finalists, path=path).finalists if path.is_file() else {}


def write_placed(placed: Placed, path: Path = CANDIDATES_FILE) -> None:
    """Writes the file of candidates whole."""
    tree = placed.model_dump(mode="json")
    _write(
        tree, [*tree["candidates"].values(), *(r for rows in tree["ruled_out"].values() for r in rows)], path
    )


def write_finalists(finalists: dict[str, Candidate], path: Path = FINALISTS_FILE) -> None:
    """Writes the file of finalists whole."""
    tree = Finalists(finalists=finalists).model_dump(mode="json")
    _write(tree, tree["finalists"].values(), path)


def _write(tree: dict[str, Any], directions: Iterable[dict[str, Any]], path: Path) -> None:
    for one in directions:  # 30 rather than 30.0, as people write it
        whole = (name for name in ("theta", "phi", "fov_deg") if one[name] == int(one[name]))
        one |= {name: int(one[name]) for name in whole}
    text = yaml.safe_dump(tree, sort_keys=False, default_flow_style=None, width=110)
    with writing(path) as aside:
        aside.write_text(_HEADS[path.name] + text, encoding="utf-8")
