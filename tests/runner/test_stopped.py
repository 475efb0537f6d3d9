"""What docs/experiments.md says of an experiment that was killed, and of the way out of it."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
import yaml

from tests.support import ROOT, Clone

STAGE = """
import pathlib, time, yaml
phi = yaml.safe_load(open("params.yaml"))["phi"]
pathlib.Path("reports/phi").write_text(str(phi))
pathlib.Path("begun").touch()
time.sleep(600 if pathlib.Path("slow").exists() else 0)
"""
WAY_OUT = (
    ("git", "switch", "main"),
    ("git", "checkout", "HEAD", "--", "params.yaml", "dvc.lock", "reports"),
)


@pytest.fixture
def repository(tmp_path: Path) -> Clone:
    """A repository whose one stage has run; where there is a file ``slow``, it never ends."""
    made = Clone(tmp_path / "a study")
    (made.root / "reports").mkdir(parents=True)
    stage = {"cmd": "python stage.py", "params": ["phi"], "metrics": [{"reports/phi": {"cache": False}}]}
    (made.root / "dvc.yaml").write_text(yaml.safe_dump({"stages": {"evaluation": stage}}))
    (made.root / "stage.py").write_text(STAGE)
    (made.root / "params.yaml").write_text("phi: 5\n")  # of another length than 30: git looks at sizes first
    (made.root / ".gitignore").write_text("/slow\n/begun\n")
    made.begin()
    return made


def status(clone: Clone) -> list[str]:
    return clone.run("git", "status", "--short", "--branch").stdout.splitlines()


def killed_while_it_runs(clone: Clone) -> None:
    """Runs an experiment and kills it, with all that it started, once its stage has begun."""
    (clone.root / "slow").touch()
    (clone.root / "begun").unlink()
    command = ["dvc", "exp", "run", "--set-param", "phi=30"]
    run = subprocess.Popen(command, cwd=clone.root, env=clone._environment(), start_new_session=True)
    begun = time.monotonic()
    while not (clone.root / "begun").exists():
        assert run.poll() is None and time.monotonic() - begun < 120
        time.sleep(0.05)
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    (clone.root / "slow").unlink()


def test_the_way_out_that_the_docs_name_brings_a_killed_experiment_back(repository: Clone) -> None:
    notes = repository.root / "stage.py"
    notes.write_text(STAGE + "# an edit of one's own\n")
    killed_while_it_runs(repository)
    found = status(repository)
    assert found[0] == "## HEAD (no branch)"
    assert {"params.yaml", "reports/phi", "stage.py"} <= {line[3:] for line in found[1:]}
    documented = (ROOT / "docs/experiments.md").read_text(encoding="utf-8")
    for command in WAY_OUT:
        assert f"    {' '.join(command)}" in documented
        repository.run(*command)
    assert status(repository) == ["## main", " M stage.py"]
    assert notes.read_text().endswith("# an edit of one's own\n")
    repository.run("dvc", "exp", "run", "--quiet", "--set-param", "phi=30")
    assert (repository.root / "reports/phi").read_text() == "30"
    assert status(repository)[0] == "## main"
