"""What a search leaves in its repeat's folder, and all repeats' together."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import polars as pl

from pipeline.control.evolution import Search
from pipeline.control.policy import save_controller

_CONTROLLER, _CURVE = "controller.npz", "curve.parquet"


def save_search(folder: Path, search: Search, frames: int) -> None:
    """Writes the incumbent and the curve of a finished search; ``frames`` are those of a generation."""
    save_controller(folder / _CONTROLLER, search.incumbent)
    search.table(frames).write_parquet(folder / _CURVE)


def gather_controllers(folders: Sequence[Path], out: Path) -> None:
    """Makes folder ``out`` with ``repeat_{r}.npz`` of each repeat's folder."""
    out.mkdir()
    for repeat, folder in enumerate(folders):
        shutil.copyfile(folder / _CONTROLLER, out / f"repeat_{repeat}.npz")


def curves(folders: Sequence[Path]) -> pl.DataFrame:
    """The curves that :func:`save_search` left in the repeats' ``folders``, with a column ``repeat``."""
    read = [pl.read_parquet(folder / _CURVE) for folder in folders]
    return pl.concat([c.insert_column(0, pl.lit(r).alias("repeat")) for r, c in enumerate(read)])
