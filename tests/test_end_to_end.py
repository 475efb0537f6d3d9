"""The whole road from params.yaml to a ranking, on the tiny budget, in a clone of its own."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import polars as pl
import psutil
import pytest
import yaml

from runner.lock import check_lock
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


def test_one_scene_from_nothing_to_an_answer_and_a_report(clone: Clone) -> None:
    clone.lend_environment()
    set_param(clone, budget="tiny")
    first = clone.run("./run", "panda_2dof", timeout_s=900).stdout
    ranking = json.loads((clone.root / "reports/rankings/panda_2dof.json").read_text())
    assert set(ranking["viewpoints"]) == BRANCHES
    assert not ranking["race"]["open"]
    assert first.splitlines()[-1] == f"panda_2dof: {ranking['answer']['sentence']}"
    allocation = yaml.safe_load((clone.root / "data/allocation.yaml").read_text())
    repeats = {key: view["repeats"] for key, view in ranking["viewpoints"].items()}
    assert repeats == {key: allocation["branches"][key]["repeats"] for key in BRANCHES}
    for key in BRANCHES:
        folder = clone.root / "reports/branches/panda_2dof" / key
        evaluation = json.loads((folder / "evaluation.json").read_text())
        episodes = pl.read_parquet(clone.root / f"data/evaluation/panda_2dof/{key}.parquet")
        assert episodes["return"].mean() == pytest.approx(evaluation["return_mean"])
        assert evaluation["return_mean"] == pytest.approx(ranking["viewpoints"][key]["return_mean"])
        curve = pl.read_csv(folder / "controller.csv")
        assert curve.columns == ["repeat", "generation", "frames", "mean", "best"]
    starts = {
        key: pl.read_parquet(clone.root / f"data/evaluation/panda_2dof/{key}.parquet")
        .filter(pl.col("repeat") < 2)
        .select("^target_.*$")
        for key in BRANCHES
    }
    assert all(table.equals(starts["study"]) for table in starts.values())  # the same for every viewpoint

    assert not ran(clone.run("./run", "dvc", "repro", "ranking@panda_2dof", timeout_s=300).stdout)
    again = clone.run("./run", "panda_2dof", timeout_s=300).stdout
    assert "begun" not in again and again.splitlines()[-1] == first.splitlines()[-1]

    joined, held, points = "data/trials.parquet", "reports/people.json", "data/people"
    words = ("--study", "data/study", "--out", joined, "--excluded", "data/excluded.csv")
    clone.run("python", "-m", "pipeline.trials", *words)
    words = ("--subjects", "data/reference/subjects.csv", "--rankings", "reports/rankings")
    words += ("--trials", joined, "--out", held, "--points", points)
    clone.run("python", "-m", "pipeline.people", *words)
    paths = ("rankings", "branches", "anchors", "pictures")
    flags = ["--coverage", "data/reference/coverage.csv", "--tried", "data/tried.csv"]
    flags += ["--people", held, "--points", points, "--record", "reports/paper"]
    flags += ["--searches", "reports/searches", "--ablations", "reports/ablations"]
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


def allocate(clone: Clone, repeats: int) -> None:
    """Gives the study, and so its scene, that many repeats at budget tiny."""
    path = clone.root / "data/allocation.yaml"
    tree = yaml.safe_load(path.read_text(encoding="utf-8")) | {"budget": "tiny"}
    tree["scenes"]["panda_2dof"] = tree["branches"]["study"]["repeats"] = repeats
    path.write_text(yaml.safe_dump(tree, sort_keys=False), encoding="utf-8")


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
    allocate(clone, 2)
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
    clone.run("git", "clean", "-fdxq", "data", "models")  # what is in git stays, such as the allocation
    clone.run("rm", "-rf", ".scratch", ".dvc/cache", "dvc.lock")
    kill_during(clone, "vae", "checkpoint.pt")
    kill_during(clone, "controller", "search.npz")
    clone.run("dvc", "repro", "evaluation@study", timeout_s=900)
    assert tracked_hashes(clone) == undisturbed

    kept = {path.name for path in (clone.root / ".scratch/vae").iterdir()}
    allocate(clone, 3)
    clone.run("dvc", "repro", "evaluation@study", timeout_s=900)
    assert len({path.name for path in (clone.root / ".scratch/vae").iterdir()} - kept) == 1


@pytest.mark.slow
def test_side_by_side_and_one_by_one_give_the_same_results(clone: Clone, tmp_path: Path) -> None:
    other = clone_repository(tmp_path / "another clone of it")
    for each, jobs in ((clone, "1"), (other, "2")):
        each.lend_environment()
        set_param(each, budget="tiny")
        each.run("./run", "--jobs", jobs, "panda_2dof", timeout_s=1800)
    serial, parallel = (
        yaml.safe_load((each.root / "dvc.lock").read_text(encoding="utf-8")) for each in (clone, other)
    )
    # new stages stand in the file in the order in which they were done
    assert set(serial["stages"]) == set(parallel["stages"])
    assert {k: v for k, v in serial["stages"].items() if v != parallel["stages"][k]} == {}
    assert serial["schema"] == parallel["schema"]


@pytest.mark.slow
def test_a_run_that_is_killed_in_any_round_ends_with_the_same_results(clone: Clone, tmp_path: Path) -> None:
    """In each kind of stage of the first round, in a later one, and while a scene is ranked."""
    undisturbed = clone_repository(tmp_path / "undisturbed")
    for each in (clone, undisturbed):
        each.lend_environment()
        set_param(each, budget="tiny", sight_share=0.99)  # or there is no race: tiny's judge sees little
        # a tolerance that no two repeats reach, so that there is a second round
        edit(each, "params.yaml", "  tolerance: 0.05 ", "  tolerance: 0.0001 ")
    undisturbed.run("./run", "panda_2dof", timeout_s=1800)
    first = [
        ".scratch/logs/anchors@*",
        *(f".scratch/{name}/*" for name in ("mdnrnn", "controller", "evaluation")),
    ]
    later = ["models/vae/*/repeat_2.pt", "reports/rankings/panda_2dof.json"]
    for sign in (".scratch/vae/*/results", *first, *later):
        kill_run(clone, sign)
    clone.run("./run", "panda_2dof", timeout_s=1800)
    assert tracked_hashes(clone) == tracked_hashes(undisturbed)
    for name in ("data/allocation.yaml", "reports/rankings/panda_2dof.json"):
        assert (clone.root / name).read_bytes() == (undisturbed.root / name).read_bytes()


@pytest.mark.slow
def test_ctrl_c_at_twenty_moments_ends_with_the_same_results(clone: Clone, tmp_path: Path) -> None:
    undisturbed = clone_repository(tmp_path / "undisturbed")
    for each in (clone, undisturbed):
        each.lend_environment()
        set_param(each, budget="tiny", sight_share=0.99)
    undisturbed.run("./run", "panda_1dof", timeout_s=1800)
    # the file is small here, and written within a millisecond
    edit(clone, "runner/dvc.py", "aside.replace(file)", "__import__('time').sleep(0.5); aside.replace(file)")
    moments = np.random.default_rng(7)
    for moment in range(20):
        process = start_run(clone, "panda_1dof")
        if moment % 4:  # long enough to get on, short enough to be met in every stage
            time.sleep(moments.uniform(1.0, 12.0))
        else:  # while dvc.lock is written
            wait_for(process, clone, ".dvc.lock.*.part")
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        ended = process.wait(timeout=60)
        assert ended in (0, 130), (moment, ended, (clone.root.parent / "said").read_text(encoding="utf-8"))
        check_lock(clone.root / "dvc.lock")
    clone.run("./run", "panda_1dof", timeout_s=1800)
    assert tracked_hashes(clone) == tracked_hashes(undisturbed)


def start_run(clone: Clone, scene: str) -> subprocess.Popen[bytes]:
    """Starts `./run` for a scene, as the leader of a group of processes, as a terminal does."""
    return subprocess.Popen(
        ["./run", scene],
        cwd=clone.root,
        env=clone._environment(),
        stdout=(clone.root.parent / "said").open("w", encoding="utf-8"),
        stderr=subprocess.STDOUT,
        start_new_session=True,
    )


def wait_for(process: subprocess.Popen[bytes], clone: Clone, sign: str) -> None:
    """Waits until there is a path of that form, or the process has ended."""
    while process.poll() is None and not list(clone.root.glob(sign)):
        time.sleep(0.001)


def kill_run(clone: Clone, sign: str) -> None:
    """Starts `./run` and ends it and all that it started with -9 as soon as a path of that form is there."""
    process = start_run(clone, "panda_2dof")
    wait_for(process, clone, sign)
    assert process.poll() is None, f"./run ended before there was {sign}"
    family = [psutil.Process(process.pid), *psutil.Process(process.pid).children(recursive=True)]
    for member in family:
        member.kill()
    psutil.wait_procs(family)
