"""The whole road from params.yaml to a ranking, on the tiny budget, in a clone of its own."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import polars as pl
import pytest
import yaml

from tests.support import Clone, clone_repository, ran

BRANCHES = {"study", "panda_2dof-a", "panda_2dof-b"}


def set_param(clone: Clone, **values: object) -> None:
    """Sets values at the top level of the clone's params.yaml, leaving all else as it is."""
    path = clone.root / "params.yaml"
    text = path.read_text(encoding="utf-8")
    for name, value in values.items():
        text, count = re.subn(rf"(?m)^{name}: \S+", f"{name}: {value}", text)
        assert count == 1
    path.write_text(text, encoding="utf-8")


def test_one_scene_from_nothing_to_a_ranking_and_a_report(clone: Clone) -> None:
    clone.lend_environment()
    set_param(clone, budget="tiny")
    first = clone.run("./run", "dvc", "repro", "ranking@panda_2dof", timeout_s=900)
    assert {f"evaluation@{key}" for key in BRANCHES} <= ran(first.stdout)
    ranking = json.loads((clone.root / "reports/rankings/panda_2dof.json").read_text())
    assert set(ranking["viewpoints"]) == BRANCHES
    for key in BRANCHES:
        folder = clone.root / "reports/branches/panda_2dof" / key
        evaluation = json.loads((folder / "evaluation.json").read_text())
        episodes = pl.read_parquet(clone.root / f"data/evaluation/panda_2dof/{key}.parquet")
        assert episodes["return"].mean() == pytest.approx(evaluation["return_mean"])
        assert evaluation["return_mean"] == pytest.approx(ranking["viewpoints"][key]["return_mean"])
        curve = pl.read_csv(folder / "controller.csv")
        assert curve.columns == ["repeat", "generation", "frames", "mean", "best"]
    starts = {
        key: pl.read_parquet(clone.root / f"data/evaluation/panda_2dof/{key}.parquet").select("^target_.*$")
        for key in BRANCHES
    }
    assert all(table.equals(starts["study"]) for table in starts.values())  # the same for every viewpoint

    again = clone.run("./run", "dvc", "repro", "ranking@panda_2dof", timeout_s=300)
    assert not ran(again.stdout)

    subjects, held = "data/reference/subjects.csv", "reports/alignment.json"
    words = ("--subjects", subjects, "--rankings", "reports/rankings", "--out", held)
    clone.run("python", "-m", "pipeline.alignment", *words)
    paths = ("rankings", "branches", "anchors", "pictures")
    flags = ["--alignment", held, "--coverage", "data/reference/coverage.csv", "--tried", "data/tried.csv"]
    flags += [part for name in paths for part in (f"--{name}", f"reports/{name}")]
    clone.run(
        "python", "-m", "pipeline.report", *flags, "--out", "reports/index.html", "--tables", "reports/tables"
    )
    page = (clone.root / "reports/index.html").read_text()
    assert all(key in page for key in BRANCHES)


def edit(clone: Clone, name: str, old: str, new: str) -> None:
    """Changes the one place in a file of the clone where ``old`` stands."""
    path = clone.root / name
    text = path.read_text(encoding="utf-8")
    assert text.count(old) == 1
    path.write_text(text.replace(old, new), encoding="utf-8")


def tracked_hashes(clone: Clone) -> dict[str, str]:
    """Every output's hash in dvc.lock."""
    lock = yaml.safe_load((clone.root / "dvc.lock").read_text())
    return {out["path"]: out["md5"] for stage in lock["stages"].values() for out in stage.get("outs", [])}


def kill_during(clone: Clone, stage: str, checkpoint: str) -> None:
    """Starts the study's ranking, and ends it with -9 once ``stage`` has written a running checkpoint."""
    environment = clone._environment()
    process = subprocess.Popen(
        ["dvc", "repro", f"{stage}@study"],
        cwd=clone.root,
        env=environment,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    begun = time.monotonic()
    while not list((clone.root / ".scratch" / stage).glob(f"*/running/{checkpoint}")):
        assert process.poll() is None, f"{stage} ended before it wrote a checkpoint"
        assert time.monotonic() - begun < 600
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert not Path(clone.root / "reports/rankings/panda_2dof.json").exists()


@pytest.mark.slow
def test_killed_stages_continue_to_the_same_hashes_and_more_repeats_train_only_the_added(
    clone: Clone, tmp_path: Path
) -> None:
    clone.lend_environment()
    set_param(clone, budget="tiny")
    edit(
        clone,
        "params.yaml",
        "vae: {epochs: 2, batch: 32, frame_stride: 5}",
        "vae: {epochs: 9, batch: 32, frame_stride: 1}",
    )
    # so small a training is over before its first checkpoint is due
    edit(clone, "pipeline/learning/training.py", "CHECKPOINT_EVERY_S = 15.0", "CHECKPOINT_EVERY_S = 0.0")
    clone.run("dvc", "repro", "evaluation@study", timeout_s=900)
    undisturbed = tracked_hashes(clone)
    for folder in ("data", "models", ".scratch", ".dvc/cache"):
        clone.run("rm", "-rf", folder)
    clone.run("rm", "-rf", "dvc.lock")
    kill_during(clone, "vae", "checkpoint.pt")
    kill_during(clone, "controller", "search.pickle")
    clone.run("dvc", "repro", "evaluation@study", timeout_s=900)
    assert tracked_hashes(clone) == undisturbed

    kept = {path.name for path in (clone.root / ".scratch/vae").iterdir()}
    edit(clone, "params.yaml", "    repeats: 2 ", "    repeats: 3 ")
    clone.run("dvc", "repro", "evaluation@study", timeout_s=900)
    assert len({path.name for path in (clone.root / ".scratch/vae").iterdir()} - kept) == 1


@pytest.mark.slow
def test_branches_side_by_side_give_the_lock_of_the_serial_run(clone: Clone, tmp_path: Path) -> None:
    other = clone_repository(tmp_path / "another clone of it")
    for each, words in ((clone, ("dvc", "repro")), (other, ("--jobs", "2"))):
        each.lend_environment()
        set_param(each, budget="tiny")
        each.run("./run", *words, "ranking@panda_2dof", timeout_s=1800)
    serial, parallel = (
        yaml.safe_load((each.root / "dvc.lock").read_text(encoding="utf-8")) for each in (clone, other)
    )
    # new stages stand in the file in the order in which they were done
    assert set(serial["stages"]) == set(parallel["stages"])
    assert {k: v for k, v in serial["stages"].items() if v != parallel["stages"][k]} == {}
    assert serial["schema"] == parallel["schema"]
