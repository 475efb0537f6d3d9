"""The published means of people, `data/reference/subjects.csv`."""

from __future__ import annotations

from pathlib import Path

from pydantic import ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.stats.agreement import Published
from pipeline.storage.tables import read_rows


def read_subjects(path: Path) -> list[Published]:
    """The published means in a CSV file, with comment lines.

    Raises:
        BelvedereError: the file is missing, or a row is not valid.
    """
    what, remedy = "table of people's means", f"it is part of the repository: `git checkout {path}`"
    try:
        found = [
            Published.model_validate(row) for row in read_rows(path, Published.model_fields, what, remedy)
        ]
    except ValidationError as error:
        first = error.errors()[0]
        raise BelvedereError(
            f"{path} holds no {what} ({first['loc'][0]} = {first['input']!r}: {first['msg']}); {remedy}."
        ) from None
    if not found:
        raise BelvedereError(f"{path} holds no {what}; {remedy}.")
    return found
