"""Holds the rankings against people: which view they were faster and more accurate with."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from pydantic import ValidationError

from pipeline.contract import params
from pipeline.contract.errors import BelvedereError
from pipeline.stats.alignment import Ranking, Trial, agreements, compare
from pipeline.storage.artefacts import write_json
from pipeline.storage.stage import entry
from pipeline.storage.tables import read_model, read_rows


def main(*, subjects: Path, rankings: Path, out: Path) -> None:
    """Reads people's trials and the folder of rankings; writes each task's comparison and the agreement."""
    trials = read_trials(subjects)
    found = {scene: rankings / f"{scene}.json" for scene in params.value("scenes")}
    ranked = {s: read_model(Ranking, path, f"ranking@{s}") for s, path in found.items() if path.is_file()}
    compared = compare(trials, ranked)
    counted = [asdict(found) for found in agreements(compared)]
    write_json(out, {"trials": [row.model_dump() for row in compared], "agreements": counted})


def read_trials(path: Path) -> list[Trial]:
    """The trials in a CSV file, with comment lines.

    Raises:
        BelvedereError: the file is missing, or a row is not valid.
    """
    what, remedy = "table of trials", f"it is part of the repository: `git checkout {path}`"
    try:
        trials = [Trial.model_validate(row) for row in read_rows(path, Trial.model_fields, what, remedy)]
    except ValidationError as error:
        first = error.errors()[0]
        raise BelvedereError(
            f"{path} holds no {what} ({first['loc'][0]} = {first['input']!r}: {first['msg']}); {remedy}."
        ) from None
    if not trials:
        raise BelvedereError(f"{path} holds no {what}; {remedy}.")
    return trials


if __name__ == "__main__":
    entry(main)
