"""A stage forked from a warm process is what `python -m` makes of it."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
import time
from pathlib import Path

import psutil
import pytest
import yaml

from runner import warm
from runner.warm import Warm
from tests.support import Clone, ran

STAGE = """
import json, os, pathlib, sys, time
import numpy as np
if __name__ == "__main__":
    what, place = sys.argv[1], pathlib.Path(sys.argv[2])
    np.ones((300, 300)) @ np.ones((300, 300))  # on the threads that the process had before it was forked
    facts = {"cwd": os.getcwd(), "home": os.environ.get("HOME"), "stage": os.environ.get("DVC_STAGE")}
    place.write_text(json.dumps({**facts, "pid": os.getpid(), "argv": sys.argv[1:]}))
    if what == "sleeps":
        time.sleep(60)
    if what == "raises":
        raise ValueError("no luck")
    sys.exit({"fails": 7, "says": "a sentence", "ends": None}[what])
"""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("warm")
    (place / "stand_in.py").write_text(STAGE, encoding="utf-8")
    return place


@pytest.fixture(scope="module")
def forked(place: Path) -> Warm:
    os.environ["PYTHONPATH"] = str(place)
    try:
        made = Warm()
        assert run(made, place, "ends")[0] == 0
    finally:
        del os.environ["PYTHONPATH"]
    return made


def run(stages: Warm, place: Path, what: str) -> tuple[int, dict]:
    facts = place / f"{what}.json"
    environment = {"DVC_STAGE": "x@y", "PATH": os.environ["PATH"]}
    status = stages.run("stand_in", [what, str(facts)], str(place), environment)
    return status, json.loads(facts.read_text())


@pytest.mark.parametrize(("what", "status"), [("ends", 0), ("fails", 7), ("says", 1), ("raises", 1)])
def test_its_status_is_passed_on_and_it_has_its_own_place(
    forked: Warm, place: Path, what: str, status: int
) -> None:
    ended, facts = run(forked, place, what)
    assert ended == status
    assert facts["cwd"] == str(place) and facts["home"] is None and facts["stage"] == "x@y"
    assert facts["argv"] == [what, str(place / f"{what}.json")]


def test_a_stage_that_is_killed_is_told_and_the_next_one_runs(forked: Warm, place: Path) -> None:
    def kill() -> None:
        facts = place / "sleeps.json"
        while not facts.exists() or not facts.read_text():
            time.sleep(0.02)
        os.kill(json.loads(facts.read_text())["pid"], signal.SIGTERM)

    threading.Thread(target=kill, daemon=True).start()
    assert run(forked, place, "sleeps")[0] == -signal.SIGTERM
    assert run(forked, place, "ends")[0] == 0


def test_each_stage_is_a_process_of_its_own(forked: Warm, place: Path) -> None:
    first, second = (run(forked, place, "ends")[1]["pid"] for _ in range(2))
    assert first != second and not psutil.pid_exists(first)


def test_a_warm_process_that_is_gone_is_a_failure(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "false")
    assert Warm().run("stand_in", [], str(place), {}) == -signal.SIGKILL


@pytest.mark.slow
def test_by_it_and_by_dvc_alone_stages_write_the_same(clone: Clone) -> None:
    params = clone.root / "params.yaml"
    params.write_text(params.read_text(encoding="utf-8").replace("budget: quick", "budget: tiny"))
    locks = []
    for command in (["dvc"], ["python", "-m", "runner.dvc"]):
        words = ("repro", "--no-run-cache", "geometry@study", "evaluation@study", "dqn@study")
        told = clone.run(*command, *words, timeout_s=900).stdout
        assert {f"{stage}@study" for stage in warm.STAGES} <= ran(told)
        locks.append(yaml.safe_load((clone.root / "dvc.lock").read_text(encoding="utf-8")))
        for name in ("dvc.lock", ".scratch", "data/frames", "models"):
            clone.run("rm", "-rf", name)
    assert locks[0] == locks[1]
