"""`./run bench`: which benchmarks it runs, and what it prints."""

from __future__ import annotations

import json
import sys
from importlib.util import find_spec
from types import ModuleType

import pytest

from benchmarks import __main__ as bench
from benchmarks.rows import AT_MOST, NO_CUDA, goal_row

GOAL = goal_row("work", "scene", 300.0, 100.0, "frames/s", 3.0, 2.0)
SIDE = {"table": "parts", "scene": "scene", "ms": 0.25}


@pytest.fixture
def two_benchmarks(monkeypatch: pytest.MonkeyPatch) -> None:
    """Benchmarks that take no time: one gives a row, the other rows of both kinds."""
    for name, found in {"one": GOAL, "both": [SIDE, {**GOAL, "work": "other"}]}.items():
        module = ModuleType(f"benchmarks.{name}")
        module.measure = lambda found=found: found  # type: ignore[attr-defined]
        monkeypatch.setitem(sys.modules, module.__name__, module)
    monkeypatch.setattr(bench, "MODULES", ("one", "both"))


def test_every_listed_benchmark_is_there() -> None:
    assert all(find_spec(f"benchmarks.{name}") for name in bench.MODULES)


def test_none_named_is_all_and_the_order_is_the_lists() -> None:
    assert bench.chosen([]) == list(bench.MODULES)
    first, second, *_ = bench.MODULES
    assert bench.chosen([second, first, second]) == [first, second]


def test_an_unknown_name_is_told_in_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as end:
        bench.main(["rendr"])
    told = capsys.readouterr()
    assert end.value.code == 1 and told.out == ""
    assert (
        told.err == f"error: benchmark 'rendr' is unknown; available: {', '.join(sorted(bench.MODULES))}.\n"
    )


@pytest.mark.usefixtures("two_benchmarks")
def test_small_tables_come_after_the_goals(capsys: pytest.CaptureFixture[str]) -> None:
    bench.main([])
    told = capsys.readouterr()
    assert told.err.startswith("machine: ") and "cores" in told.err
    words = [text.split() for text in told.out.splitlines()]
    assert [row[0] for row in words if row] == ["work", "work", "other", "parts:", "scene", "scene"]
    assert words[1] == ["work", "scene", "300", "100", "frames/s", "3", "≥", "2", "yes"]


@pytest.mark.usefixtures("two_benchmarks")
def test_json_is_one_object_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    bench.main(["--json", "both"])
    assert [json.loads(text) for text in capsys.readouterr().out.splitlines()] == [
        SIDE,
        {**GOAL, "work": "other"},
    ]


def test_an_empty_row_of_a_device_that_is_not_there_can_be_printed() -> None:
    row = goal_row("closed loop, one GPU", "panda_2dof", None, 36_900, "frames/s", None, 1e5, note=NO_CUDA)
    assert row["holds"] is None
    assert bench.line(row).split()[5:] == [
        "–",
        "36900",
        "frames/s",
        "–",
        "≥",
        "100000",
        "–",
        *NO_CUDA.split(),
    ]


def test_a_limit_is_kept_from_below() -> None:
    kept, broken = (goal_row("w", "s", 1.0, 2.0, "ms", r, 0.05, AT_MOST) for r in (0.05, 0.051))
    assert kept["holds"] is True and broken["holds"] is False
    assert "≤ 0.05 yes" in " ".join(bench.line(kept).split())
