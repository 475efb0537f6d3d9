"""CSV files as data frames of stated columns."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import polars as pl

from pipeline.contract.errors import BelvedereError
from pipeline.storage.tables import read_rows


def read_frame(path: Path, columns: Mapping[str, Any], what: str, remedy: str) -> pl.DataFrame:
    """Reads what :func:`pipeline.storage.tables.read_rows` does, each column as the type given.

    Raises:
        BelvedereError: as there, or a value is not of its column's type.
    """
    rows = read_rows(path, columns, what, remedy)
    try:
        return pl.DataFrame(rows, schema=dict.fromkeys(columns, pl.String)).cast(pl.Schema(columns))
    except pl.exceptions.PolarsError as error:
        reason = " ".join(str(error).split())[:120]
        raise BelvedereError(f"{path} holds no {what} ({reason}); {remedy}.") from None
