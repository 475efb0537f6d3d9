"""Reading learning curves, whole: of a controller's search, and of a deep Q-network."""

from __future__ import annotations

from pathlib import Path

import polars as pl

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.csv_frames import read_frame

COLUMNS = {
    "repeat": pl.Int64,
    "generation": pl.Int64,
    "frames": pl.Int64,
    "mean": pl.Float64,
    "best": pl.Float64,
}


def read_curve(path: Path, made_by: str, repeats: int) -> pl.DataFrame:
    """The curves of a view's searches.

    Args:
        path: the CSV file.
        made_by: the stage that writes it, named in errors.
        repeats: of which there must be a curve.

    Raises:
        BelvedereError: the file is missing or foreign, or a part of it is.
    """
    curve = _read(path, made_by)
    found = curve["repeat"].n_unique()
    if found != repeats:
        raise BelvedereError(
            f"{path} holds curves of {found} repeats, but {repeats} are ranked; run `dvc repro {made_by}`."
        )
    return curve


def read_dqn_curve(path: Path, made_by: str) -> pl.DataFrame | None:
    """The same of Q-networks; None where none was trained."""
    curve = _read(path, made_by) if path.is_file() else None
    return None if curve is None or curve.is_empty() else curve


def _read(path: Path, made_by: str) -> pl.DataFrame:
    what, remedy = "learning curve", f"delete it and run `dvc repro {made_by}`"
    curve = read_frame(path, COLUMNS, what, remedy)
    ends = curve.group_by("repeat").agg(pl.len(), last=pl.col("generation").max() + 1)
    if ends["len"].n_unique() > 1 or not ends["len"].equals(ends["last"].cast(pl.UInt32)):
        raise BelvedereError(f"{path} holds no whole {what} of each repeat; {remedy}.")
    return curve
