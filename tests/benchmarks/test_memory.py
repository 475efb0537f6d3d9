"""The most memory that a stage held is that of its own process."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import pytest

from benchmarks.memory import KEY, STAGES, peak_mib
from benchmarks.training import command
from pipeline.contract.errors import BelvedereError
from pipeline.storage.stage import parser


def held(folder: Path, code: str) -> float:
    (folder / "work.py").write_text(code)
    return peak_mib(folder, ["-m", "work"])


def test_what_a_process_holds_is_counted(tmp_path: Path) -> None:
    """Bytes that are written and freed before the end count; those of another process do not."""
    beside = bytearray(400 << 20)
    small, large = (held(tmp_path, f"x = bytearray({n} << 20); del x") for n in (1, 300))
    assert large - small == pytest.approx(299, rel=0.1)
    assert small < len(beside) / 2**20 / 4


def test_what_fails_is_told(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match=r"ended with status 1: .*no such thing"):
        held(tmp_path, "raise SystemExit('no such thing')")


@pytest.mark.parametrize("stage", STAGES)
def test_each_stage_takes_the_flags_that_it_is_given(stage: str) -> None:
    _, name, *flags = command(stage, KEY, {"scene": "panda_1dof", "theta": 60, "phi": 35})
    assert parser(import_module(name).main).parse_args(flags)
