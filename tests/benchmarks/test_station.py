"""What the benchmark of the station says of a run."""

from __future__ import annotations

import os

import pytest

from benchmarks.station import Memory, _rows
from pipeline.station.operate import Report


def test_memory_that_stays_has_grown_by_nothing_and_a_leak_shows() -> None:
    memory = Memory(os.getpid(), Report(), 6)
    assert memory.growth_mib() is None
    memory.samples = [700.0] * 100
    assert memory.growth_mib() == 0
    memory.samples = [700.0 + second / 10 for second in range(900)]
    assert memory.growth_mib() == pytest.approx(81, abs=1)


def test_rates_are_those_between_pictures_and_latencies_their_quantiles() -> None:
    report = Report(intervals_s=[0.04] * 250, latencies_ms=[float(ms) for ms in range(101)], renderer="x")
    rate, middle, high, grown = _rows(report, 3.0, 60.0)
    assert rate["ours"] == pytest.approx(25) and rate["holds"]
    assert middle["ours"] == 50 and middle["holds"] and high["ours"] == 95
    assert grown["ours"] == 3.0 and grown["holds"]


def test_a_run_without_pictures_has_rows_all_the_same() -> None:
    assert all(row["ours"] is None and row["holds"] is None for row in _rows(Report(), None, 60.0))
