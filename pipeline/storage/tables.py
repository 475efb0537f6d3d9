"""Reading tables, checked: JSON against a type, CSV against its columns."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import read_json

ModelT = TypeVar("ModelT", bound=BaseModel)


def read_model(model: type[ModelT], path: Path, made_by: str) -> ModelT:
    """Reads a JSON table.

    Args:
        model: its type.
        path: the JSON file.
        made_by: the stage that writes it, named in errors.

    Raises:
        BelvedereError: the file is missing or foreign, or an entry is missing or not valid.
    """
    try:
        return model.model_validate(read_json(path, made_by))
    except ValidationError as error:
        first = error.errors()[0]
        place = ".".join(str(part) for part in first["loc"])
        raise BelvedereError(
            f"{path}: {place} is not valid ({first['msg']}); `dvc repro {made_by}` makes it again."
        ) from None


def read_rows(path: Path, columns: Iterable[str], what: str, remedy: str) -> list[dict[str, str]]:
    """Reads a CSV file whose lines may be comments (``#``): of each row the values of ``columns``.

    Args:
        path: the file.
        columns: those that there must be; others are skipped.
        what: what the file should hold, named in errors.
        remedy: how one gets it, a sentence's last part.

    Raises:
        BelvedereError: the file is missing, is no such table or is cut short.
    """
    try:
        header, *rows = _records(path)
        missing = [name for name in columns if name not in header]
        if missing:
            raise ValueError(f"it has no column {', '.join(missing)}")
        return [{name: row[header.index(name)] for name in columns} for row in rows]
    except FileNotFoundError:
        raise BelvedereError(f"{path} is missing; {remedy}.") from None
    except (ValueError, csv.Error) as error:
        raise BelvedereError(f"{path} holds no {what} ({error}); {remedy}.") from None


def _records(path: Path) -> list[list[str]]:
    text = path.read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    records = list(csv.reader(lines, strict=True))
    if not records:
        raise ValueError("it is empty")
    if any(len(record) != len(records[0]) for record in records) or not text.endswith("\n"):
        raise ValueError("a line is cut short")
    return records
