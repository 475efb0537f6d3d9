"""What stage tests share: an empty folder to run a stage in."""

from __future__ import annotations

from pathlib import Path

import pytest


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with a scratch store of its own; stages use one thread of the CPU there."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path / "scratch"))
    monkeypatch.setenv("BELVEDERE_CORES", "1")
    monkeypatch.setenv("BELVEDERE_DEVICE", "cpu")
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    return tmp_path
