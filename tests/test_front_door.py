"""The front door, without what takes minutes: that it starts, says what is wrong, and passes things on."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

from tests.support import ROOT, Clone

LOCK = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()


@pytest.mark.parametrize("script", ["run", ".ci/run"])
def test_scripts_are_posix_and_may_be_started(script: str) -> None:
    assert (ROOT / script).stat().st_mode & 0o111
    assert (ROOT / script).read_text(encoding="utf-8").startswith("#!/bin/sh\n")
    subprocess.run(["sh", "-n", str(ROOT / script)], check=True)


def test_the_lock_pins_everything_and_names_no_address() -> None:
    for line in LOCK:
        assert re.fullmatch(r"[a-z0-9-]+==[0-9][0-9a-z.]*( ; .+)?", line), line


def test_the_lock_leaves_cuda_to_torch() -> None:
    assert [line for line in LOCK if line.startswith(("nvidia-", "cuda-", "triton"))] == []


def test_the_lock_has_what_pyproject_asks_for() -> None:
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    assert set(asked["project"]["dependencies"]) | set(asked["dependency-groups"]["dev"]) <= set(LOCK)


def test_dvc_neither_reports_nor_looks_for_updates() -> None:
    config = (ROOT / ".dvc" / "config").read_text(encoding="utf-8")
    assert "analytics = false" in config and "check_update = false" in config


def test_help_needs_no_environment(clone: Clone) -> None:
    told = clone.run("./run", "--help").stdout
    for task in ("test", "check", "bench", "dvc", "station", "--jobs"):
        assert f"./run {task}" in told
    assert not (clone.root / ".venv").exists()


def test_a_python_that_is_none_is_told(clone: Clone) -> None:
    told = clone.run("./run", "true", status=2, PYTHON="python-of-nowhere").stderr
    assert "'python-of-nowhere' is no Python 3.11 or newer" in told
    assert not (clone.root / ".venv").exists()


def test_an_unknown_task_is_told(clone: Clone) -> None:
    clone.lend_environment()
    told = clone.run("./run", "chekc", status=2).stderr
    assert "'chekc' is no task (test, check, bench, search, ablation, station), no scene and no" in told


def test_a_command_runs_in_the_environment_from_the_root(clone: Clone, tmp_path: Path) -> None:
    clone.lend_environment()
    code = "import os, sys; print(os.getcwd(), sys.prefix, sys.argv[1:], sep='\\n')"
    arguments = ["two words", "*", "$HOME", ""]
    done = subprocess.run(
        [clone.root / "run", "python", "-c", code, *arguments],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines() == [str(clone.root), str(clone.root / ".venv"), str(arguments)]


def test_the_callers_python_packages_stay_outside(clone: Clone, tmp_path: Path) -> None:
    """A sourced ROS sets PYTHONPATH, where pytest finds plugins, and other versions of what we use lie."""
    clone.lend_environment()
    foreign = tmp_path / "site"
    (foreign / "ros-1.0.dist-info").mkdir(parents=True)
    (foreign / "ros-1.0.dist-info/METADATA").write_text("Metadata-Version: 2.1\nName: ros\nVersion: 1.0\n")
    (foreign / "ros-1.0.dist-info/entry_points.txt").write_text("[pytest11]\nros = ros_plugin\n")
    for name in ("ros_plugin", "numpy", "yaml"):
        (foreign / f"{name}.py").write_text("raise ImportError('foreign')\n", encoding="utf-8")
    callers = {
        "PYTHONPATH": str(foreign),
        "PYTHONSAFEPATH": "1",
        "PYTHONOPTIMIZE": "1",
        "PYTEST_ADDOPTS": "--nope",
    }
    clone.run("./run", "test", "tests/contract/test_split.py", "-k", "kept", **callers)
    said = clone.run(
        "./run", "python", "-c", "import numpy, pipeline; assert False", status=None, **callers
    ).stderr
    assert "AssertionError" in said


def test_a_commands_status_is_passed_on(clone: Clone) -> None:
    clone.lend_environment()
    clone.run("./run", "python", "-c", "raise SystemExit(7)", status=7)


def test_test_passes_its_arguments_to_pytest(clone: Clone) -> None:
    clone.lend_environment()
    done = clone.run("./run", "test", "--slow", "tests/contract/test_split.py", "-k", "share and kept")
    assert "1 passed" in done.stdout


def test_a_changed_lock_makes_the_environment_anew(clone: Clone) -> None:
    clone.lend_environment()
    with (clone.root / "requirements.lock").open("a", encoding="utf-8") as lock:
        lock.write("no-such-package==1.0\n")
    told = clone.run("./run", "true", status=2, PYTHON="python-of-nowhere").stderr
    assert "python-of-nowhere" in told


def test_an_environment_of_another_place_is_thrown_away(clone: Clone, tmp_path: Path) -> None:
    """pip would find all installed, and leave scripts that name the other place's Python."""
    venv, python = clone.root / ".venv", tmp_path / "python"
    (venv / "bin").mkdir(parents=True)
    lock = (clone.root / "requirements.lock").read_text(encoding="utf-8")
    (venv / "stamp").write_text(f"# /elsewhere\n{lock}", encoding="utf-8")
    python.write_text('#!/bin/sh\ntest "$1" = -c\n', encoding="utf-8")  # a Python that makes no environment
    python.chmod(0o755)
    told = clone.run("./run", "true", status=None, PYTHON=str(python))
    assert told.returncode != 0 and not (venv / "bin").exists()
