"""A run kept in git beside the results: controllers searched for from zero, as the paper does."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.results import SceneResults, read_results
from pipeline.reporting.tables import Table
from pipeline.storage.tables import read_model

ABOUT = "about.json"


class About(Table):
    """How the record was made, ``about.json``.

    Attributes:
        scenes: in the page's order.
        changes: of params.yaml, as DVC's ``-S`` has them.
        commit: of the code.
        date: when it ended.
    """

    scenes: list[str]
    changes: list[str]
    commit: str
    date: str


@dataclass(frozen=True)
class Record:
    """The record's scenes, and what is said of how they were made."""

    about: About
    scenes: list[SceneResults]


def read_record(folder: Path) -> Record | None:
    """Reads the record; ``None`` where none is kept.

    Raises:
        BelvedereError: a table is missing, foreign or incomplete.
    """
    if not (folder / ABOUT).is_file():
        return None
    rankings, branches, anchors = (folder / name for name in ("rankings", "branches", "anchors"))
    try:
        about = read_model(About, folder / ABOUT, "report")
        scenes, missing = read_results(about.scenes, rankings, branches, anchors)
        if missing:
            raise BelvedereError(f"{folder} has no ranking of {', '.join(missing)}")
        return Record(about, scenes)
    except BelvedereError as error:  # whose remedy is a stage, and no stage makes the record
        fault = str(error).partition(";")[0]
        raise BelvedereError(f"{fault}; `git checkout {folder}` brings it back.") from None
