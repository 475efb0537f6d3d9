"""What `./run --jobs` takes and passes on."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.machine import CORES_VARIABLE
from runner.__main__ import number_of_jobs
from runner.schedule import default_jobs
from tests.support import Clone


@pytest.mark.parametrize("given", ["0", "-1", "two", "1.5", "", "²", " 2"])
def test_a_number_of_jobs_that_is_none_is_refused(given: str) -> None:
    with pytest.raises(BelvedereError, match="whole number from 1 up"):
        number_of_jobs(given)


@pytest.mark.parametrize("arguments", [["--jobs", "two"], ["--jobs=0"], ["--jobs"]])
def test_the_front_door_says_so_in_one_sentence(clone: Clone, arguments: list[str]) -> None:
    clone.lend_environment()
    done = clone.run("./run", *arguments, status=1)
    assert done.stdout == "" and len(done.stderr.splitlines()) == 1
    assert done.stderr.startswith("error: --jobs ")


def test_an_unknown_scene_is_told_with_those_that_there_are(clone: Clone) -> None:
    clone.lend_environment()
    told = clone.run("./run", "--jobs", "1", "panda_9dof", status=1).stderr
    assert told.startswith("error: scene 'panda_9dof' is unknown; available: fetch_reach, panda_1dof")


def test_a_gpu_is_left_to_one_viewpoint_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(CORES_VARIABLE, "6")
    monkeypatch.setattr("runner.schedule._NVIDIA", tmp_path / "none")
    assert default_jobs() == 6
    monkeypatch.setattr("runner.schedule._NVIDIA", tmp_path)
    assert default_jobs() == 1
