"""The table of trials: what does not count, and why."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import polars as pl
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.study.params import ExcludeParams
from pipeline.study.records import TrialRecord
from pipeline.study.trials import COUNTS, SCHEMA, excluded_table, read_trials, trials_table
from tests.study.sessions import line

RULES = ExcludeParams(
    p95_latency_ms=100, real_time_factor=0.98, least_time_s=0.5, outcomes=("timeout", "aborted")
)
NOTHING = {"time_s": None, "distance_m": None}


def table(*changes: dict[str, Any]) -> pl.DataFrame:
    lines = [line(trial=number, **change) for number, change in enumerate(changes, start=1)]
    return trials_table([TrialRecord.model_validate(made) for made in lines], RULES)


@pytest.mark.parametrize(
    ("change", "reasons"),
    [
        ({}, []),
        ({"latency_ms_p95": 100.0, "real_time_factor": 0.98, "time_s": 0.5}, []),  # the limits themselves
        ({"flags": ["latency"]}, []),  # a flag is the station's; the rules here decide
        ({"latency_ms_p95": 100.1}, ["latency above the limit"]),
        ({"latency_ms_p95": None}, ["latency not measured"]),
        ({"real_time_factor": 0.979}, ["slower than real time"]),
        ({"real_time_factor": None}, ["real-time factor not measured"]),
        ({"time_s": 0.4}, ["shorter than an attempt to reach"]),
        (
            {"time_s": 0.4, "latency_ms_p95": 300.0},
            ["latency above the limit", "shorter than an attempt to reach"],
        ),
        ({"outcome": "timeout", **NOTHING}, ["timeout"]),
        ({"outcome": "aborted", **NOTHING, "latency_ms_p95": None}, ["aborted"]),
    ],
)
def test_each_rule_has_its_reason(change: dict[str, Any], reasons: list[str]) -> None:
    found = table({}, change)
    assert found["reasons"].to_list() == [[], reasons]
    assert found.filter(COUNTS)["trial"].to_list() == [1, *([2] if not reasons else [])]
    left_out = excluded_table(found)
    assert left_out["reasons"].to_list() == (["; ".join(reasons)] if reasons else [])


def test_nobody_gives_an_empty_table_of_the_same_form(tmp_path: Path) -> None:
    empty, some = table(), table({})
    assert len(empty) == 0 and dict(empty.schema) == dict(some.schema) == SCHEMA
    empty.write_parquet(tmp_path / "t.parquet")
    assert read_trials(tmp_path / "t.parquet").equals(empty)
    assert excluded_table(empty).columns == excluded_table(some).columns


def test_a_foreign_table_is_told(tmp_path: Path) -> None:
    path = tmp_path / "trials.parquet"
    for content in (None, b"", b"no Parquet"):
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(BelvedereError, match="dvc repro trials"):
            read_trials(path)
    pl.DataFrame({"participant": ["sub-ab2cd3"]}).write_parquet(path)
    with pytest.raises(BelvedereError, match="holds no table of trials"):
        read_trials(path)
