"""The table of all sessions' ended attempts, `data/trials.parquet`, and which of them do not count."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import polars as pl

from pipeline.contract.errors import BelvedereError
from pipeline.study.params import ExcludeParams
from pipeline.study.records import TrialRecord

_PLACE = pl.Array(pl.Float64, 3)
RECORDED: dict[str, pl.DataType] = {
    "participant": pl.String(), "session": pl.Int64(), "operator": pl.String(), "trial": pl.Int64(),
    "attempt": pl.Int64(), "block": pl.Int64(), "scene": pl.String(), "view": pl.String(),
    "theta": pl.Float64(), "phi": pl.Float64(), "target_index": pl.Int64(), "start_m": _PLACE,
    "target_m": _PLACE, "tip_m": _PLACE, "outcome": pl.String(), "time_s": pl.Float64(),
    "wall_s": pl.Float64(), "distance_m": pl.Float64(), "path_m": pl.Float64(), "inputs": pl.Int64(),
    "touched": pl.Boolean(), "input": pl.String(), "device": pl.String(), "latency_ms_p50": pl.Float64(),
    "latency_ms_p95": pl.Float64(), "real_time_factor": pl.Float64(), "frames_sent": pl.Int64(),
    "frames_dropped": pl.Int64(), "flags": pl.List(pl.String()), "frame": pl.String(),
    "renderer": pl.String(), "picture": pl.List(pl.Int64()), "started_at": pl.Datetime("us", "UTC"),
    "ended_at": pl.Datetime("us", "UTC"),
}  # fmt: skip
SCHEMA = RECORDED | {"reasons": pl.List(pl.String())}  # why a row does not count; empty where it does
COUNTS = pl.col("reasons").list.len() == 0
EXCLUDED = (
    *("participant", "session", "trial", "attempt", "scene", "view"),
    *("outcome", "time_s", "latency_ms_p95", "real_time_factor"),
)


def trials_table(records: Sequence[TrialRecord], rules: ExcludeParams) -> pl.DataFrame:
    """One row an ended attempt, in the order given, with the reasons for which it does not count."""
    rows = [record.model_dump() for record in records]
    return pl.DataFrame(rows, schema=RECORDED).with_columns(_reasons(rules)).select(*SCHEMA)


def _reasons(rules: ExcludeParams) -> pl.Expr:
    """The reasons as a list; of an attempt whose outcome does not count, that alone."""
    outcome = pl.col("outcome").is_in(list(rules.outcomes))
    late, slow = pl.col("latency_ms_p95"), pl.col("real_time_factor")
    cases = {
        "latency above the limit": late > rules.p95_latency_ms,
        "latency not measured": late.is_null(),
        "slower than real time": slow < rules.real_time_factor,
        "real-time factor not measured": slow.is_null(),
        "shorter than an attempt to reach": pl.col("time_s") < rules.least_time_s,
    }
    told = [pl.when(outcome).then(pl.col("outcome"))]
    told += [pl.when(~outcome & case).then(pl.lit(name)) for name, case in cases.items()]
    return pl.concat_list(told).list.drop_nulls().alias("reasons")


def excluded_table(trials: pl.DataFrame) -> pl.DataFrame:
    """The rows that do not count, each with its reasons as one text."""
    left_out = trials.filter(~COUNTS)
    return left_out.select(*EXCLUDED, pl.col("reasons").list.join("; "))


def read_trials(path: Path) -> pl.DataFrame:
    """The table as stage `trials` left it.

    Raises:
        BelvedereError: it is missing, or no such table.
    """
    return read_table(path, SCHEMA, "trials")


def read_table(path: Path, schema: Mapping[str, pl.DataType], stage: str) -> pl.DataFrame:
    """A table that a stage of the study wrote.

    Raises:
        BelvedereError: it is missing, or no such table.
    """
    try:
        found = pl.read_parquet(path)
    except FileNotFoundError:
        raise BelvedereError(f"{path} is missing; `dvc repro {stage}` makes it.") from None
    except (pl.exceptions.PolarsError, OSError):
        raise BelvedereError(f"{path} is no Parquet file; delete it and run `dvc repro {stage}`.") from None
    if dict(found.schema) != schema:
        raise BelvedereError(f"{path} holds no table of {stage}; delete it and run `dvc repro {stage}`.")
    return found
