"""The benchmark's training starts the stages as dvc.yaml does."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from benchmarks.training import BRANCH, STAGES, command, trained

VIEW = {"scene": "panda_2dof", "theta": 0, "phi": 0}
DVC = yaml.safe_load(Path("dvc.yaml").read_text(encoding="utf-8"))["stages"]


@pytest.mark.parametrize("stage", ("rollouts", *STAGES))
def test_commands_are_those_of_dvc_yaml(stage: str) -> None:
    words = command(stage, BRANCH, VIEW)
    assert words[:2] == ["-m", f"pipeline.{stage}"]
    assert not any("$" in word for word in words)
    assert flags(words) == flags(DVC[stage]["do"]["cmd"].split())
    if stage != "rollouts":
        assert any(BRANCH in word for word in words)


def flags(words: list[str]) -> list[str]:
    return [word.partition("=")[0] for word in words if word.startswith("--")]


@pytest.mark.slow
def test_a_tiny_training_runs_from_end_to_end(tmp_path: Path) -> None:
    seconds = trained(tmp_path, "tiny", repeats=2)
    assert tuple(seconds) == STAGES and min(seconds.values()) > 0
    assert (tmp_path / "models" / "controller" / BRANCH / "repeat_1.npz").is_file()
    assert not (tmp_path / "models" / "controller" / BRANCH / "repeat_2.npz").exists()
