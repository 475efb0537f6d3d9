"""Holds the rankings against people: which view they were faster and more accurate with."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import polars as pl
from pydantic import ValidationError

from pipeline.contract import params
from pipeline.contract.artefacts import read_json, write_json
from pipeline.contract.errors import BelvedereError
from pipeline.contract.stage import entry
from pipeline.stats.alignment import Trial, agreements, compare


def main(*, subjects: Path, rankings: Path, out: Path) -> None:
    """Reads people's trials and the folder of rankings; writes each task's comparison and the agreement."""
    trials = read_trials(subjects)
    found = {scene: rankings / f"{scene}.json" for scene in params.value("scenes")}
    contents = {s: read_json(path, f"ranking@{s}") for s, path in found.items() if path.is_file()}
    compared = compare(trials, contents)
    counted = [asdict(found) for found in agreements(compared)]
    write_json(out, {"trials": [row.model_dump() for row in compared], "agreements": counted})


def read_trials(path: Path) -> list[Trial]:
    """The trials in a CSV file, with comment lines.

    Raises:
        BelvedereError: the file is missing, or a row is not valid.
    """
    if not path.is_file():
        raise BelvedereError(f"{path} is missing; it is part of the repository: `git checkout {path}`.")
    try:
        return [Trial.model_validate(row) for row in pl.read_csv(path, comment_prefix="#").to_dicts()]
    except (pl.exceptions.PolarsError, ValidationError) as error:
        reason = error.errors()[0] if isinstance(error, ValidationError) else error
        raise BelvedereError(
            f"{path} holds no table of trials: {' '.join(str(reason).split())[:200]}."
        ) from None


if __name__ == "__main__":
    entry(main)
