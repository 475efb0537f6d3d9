"""Learning curves are read whole or refused."""

from __future__ import annotations

from pathlib import Path

import polars as pl
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.reporting.curve_files import read_curve, read_dqn_curve

REPEATS, GENERATIONS = 3, 4


def curves() -> pl.DataFrame:
    rows = [(r, g, 100 * (g + 1), -1.5 + r, -1.25 + g) for r in range(REPEATS) for g in range(GENERATIONS)]
    return pl.DataFrame(rows, schema=["repeat", "generation", "frames", "mean", "best"], orient="row")


def test_curves_come_back(tmp_path: Path) -> None:
    curves().write_csv(tmp_path / "curve.csv")
    assert read_curve(tmp_path / "curve.csv", "controller@a", REPEATS).equals(curves())
    assert read_dqn_curve(tmp_path / "none.csv", "dqn@a") is None


def test_cut_short_anywhere_they_are_refused(tmp_path: Path) -> None:
    curves().write_csv(tmp_path / "curve.csv")
    whole = (tmp_path / "curve.csv").read_bytes()
    for end in range(len(whole)):
        (tmp_path / "curve.csv").write_bytes(whole[:end])
        with pytest.raises(BelvedereError, match=r"curve\.csv .*dvc repro controller@a"):
            read_curve(tmp_path / "curve.csv", "controller@a", REPEATS)


@pytest.mark.parametrize("repeats", [REPEATS - 1, REPEATS + 1])
def test_of_another_number_of_repeats_they_are_refused(tmp_path: Path, repeats: int) -> None:
    curves().write_csv(tmp_path / "curve.csv")
    with pytest.raises(BelvedereError, match=f"holds curves of 3 repeats, but {repeats} are ranked"):
        read_curve(tmp_path / "curve.csv", "controller@a", repeats)


def test_a_generation_that_is_lacking_is_told(tmp_path: Path) -> None:
    curves().filter(pl.col("generation") != 1).write_csv(tmp_path / "curve.csv")
    with pytest.raises(BelvedereError, match="no whole learning curve"):
        read_curve(tmp_path / "curve.csv", "controller@a", REPEATS)
