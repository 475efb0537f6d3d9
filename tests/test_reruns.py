"""What DVC runs again after a change, with stages that only hash what they read and are done at once."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
import yaml

from tests.support import ROOT, Clone, clone_repository, ran

pytestmark = pytest.mark.slow

PARAMS = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
STAGES = yaml.safe_load((ROOT / "dvc.yaml").read_text(encoding="utf-8"))["stages"]
FAN_IN = {f"ranking@{scene}" for scene in PARAMS["scenes"]} | {"trials", "people", "report"}
BRANCH_STAGES = (
    *("frames", "geometry", "operator", "vae", "latents"),
    *("mdnrnn", "controller", "evaluation", "dqn"),
)

# Inputs are the flags whose paths exist; all other paths are written.
STAND_IN = """
import hashlib, json, pathlib, sys, yaml
words = sys.argv[1:]
paths = {flag: pathlib.Path(value) for flag, value in zip(words[::2], words[1::2]) if "/" in value}
digest = hashlib.md5(" ".join(words).encode())
if "--branch" in words:
    allocation = yaml.safe_load(pathlib.Path("data/allocation.yaml").read_text())
    digest.update(str(allocation["branches"][words[words.index("--branch") + 1]]).encode())
inputs = {flag for flag in paths if paths[flag].exists() and flag not in ("--out", "--metrics", "--picture")}
for flag in sorted(inputs):
    files = [paths[flag]] if paths[flag].is_file() else sorted(paths[flag].rglob("*"))
    for file in files:
        digest.update(file.read_bytes() if file.is_file() else b"")
for path in (paths[flag] for flag in paths if flag not in inputs):
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix in ("", ".zarr"):
        path.mkdir()
        path = path / "content"
    number = int(digest.hexdigest()[:8], 16)
    answer = {"sentence": str(number), "progress": ""}
    race = {"open": False, "common": 3, "active": []}
    ranking = {"digest": number, "scene": path.stem, "answer": answer, "race": race, "most": 20}
    path.write_text(json.dumps(ranking) if path.suffix == ".json" else f"a,b\\n{number},{path}\\n")
"""


def branch(key: str) -> set[str]:
    return {f"{stage}@{key}" for stage in BRANCH_STAGES if key in STAGES[stage]["foreach"]}


def exp_run(clone: Clone, *arguments: str) -> set[str]:
    """The stages that `./run dvc exp run` ran, not those that DVC took from its cache."""
    return ran(clone.run("./run", "dvc", "exp", "run", *arguments, timeout_s=1800).stdout)


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> Clone:
    """A clone in which the whole pipeline ran and its results are committed."""
    clone = clone_repository(tmp_path_factory.mktemp("done") / "a clone of it")
    for stage in STAGES:
        (clone.root / "pipeline" / f"{stage}.py").write_text(STAND_IN, encoding="utf-8")
    clone.lend_environment()
    clone.commit("stages that are done at once")
    told = clone.run("./run", timeout_s=1800).stdout
    assert all(f"{scene}: " in told for scene in PARAMS["scenes"])
    assert told.splitlines()[-1] == f"Report: {clone.root / 'reports' / 'index.html'}"
    clone.commit("its results")
    return clone


def test_nothing_changed_nothing_runs(done: Clone) -> None:
    assert ran(done.run("./run").stdout) == set()


def test_one_more_repeat_of_one_viewpoint_runs_its_branch_and_draws_episodes(
    done: Clone, tmp_path: Path
) -> None:
    done.run("git", "clone", "--quiet", done.root, tmp_path / "more")
    fresh = Clone(tmp_path / "more")
    fresh.lend_environment()
    shutil.copytree(done.root / ".dvc" / "cache", fresh.root / ".dvc" / "cache")
    fresh.run("dvc", "checkout", "--quiet")
    path = fresh.root / "data/allocation.yaml"
    allocation = yaml.safe_load(path.read_text(encoding="utf-8"))
    allocation["branches"]["fetch_reach-c"]["repeats"] += 1
    allocation["scenes"]["fetch_reach"] += 1
    path.write_text(yaml.safe_dump(allocation), encoding="utf-8")
    told = ran(fresh.run("./run", "dvc", "repro", timeout_s=1800).stdout)
    kept = {f"{s}@fetch_reach-c" for s in ("geometry", "operator", "dqn")}
    grown = {f"{s}@fetch_reach-c" for s in BRANCH_STAGES} - kept
    assert told == grown | {"rollouts@fetch_reach", "ranking@fetch_reach", "people", "report"}


def test_the_study_runs_before_its_scenes_candidates(done: Clone) -> None:
    order = re.findall(r"Running stage '([^']+)'", done.run("dvc", "repro", "--dry", "--force").stdout)
    scene = PARAMS["viewpoint"]["scene"]
    begun = order.index(f"scene@{scene}")
    assert order[begun : begun + 2] == [f"scene@{scene}", f"rollouts@{scene}"]
    of_branches = [stage for stage in order[begun:] if stage.endswith("@study") or f"@{scene}-" in stage]
    assert of_branches[:3] == ["geometry@study", "operator@study", "frames@study"]


def test_side_by_side_gives_the_serial_lock_and_no_stage_runs_twice(done: Clone, tmp_path: Path) -> None:
    locks = {}
    ways = {"serial": ("--jobs", "1", "panda_2dof"), "side by side": ("--jobs", "3", "panda_2dof")}
    for name, words in ways.items():
        done.run("git", "clone", "--quiet", done.root, tmp_path / name)
        fresh = Clone(tmp_path / name)
        fresh.lend_environment()
        params = (fresh.root / "params.yaml").read_text(encoding="utf-8")
        former = "panda_2dof-b: {scene: panda_2dof, theta: 90, phi: 0}"
        assert params.count(former) == 1
        changed = params.replace(former, former.replace("phi: 0", "phi: 7"))
        (fresh.root / "params.yaml").write_text(changed, encoding="utf-8")
        told = fresh.run("./run", *words, timeout_s=1800).stdout
        logs = [file.read_text(encoding="utf-8") for file in (fresh.root / ".scratch/logs").glob("*.log")]
        runs = re.findall(r"Running stage '([^']+)'", "".join([told, *logs]))
        assert len(runs) == len(set(runs)) and branch("panda_2dof-b") | {"ranking@panda_2dof"} <= set(runs)
        locks[name] = (fresh.root / "dvc.lock").read_bytes()
    assert locks["serial"] == locks["side by side"]
    assert locks["serial"] != (done.root / "dvc.lock").read_bytes()


def test_a_stage_that_fails_beside_others_is_named(done: Clone, tmp_path: Path) -> None:
    done.run("git", "clone", "--quiet", done.root, tmp_path / "fails")
    fresh = Clone(tmp_path / "fails")
    fresh.lend_environment()
    with (fresh.root / "pipeline" / "mdnrnn.py").open("a", encoding="utf-8") as stage:
        stage.write("raise SystemExit('no luck' if 'panda_2dof-a' in sys.argv[-1] else 0)\n")
    failed = fresh.run("./run", "--jobs", "2", "panda_2dof", status=1, timeout_s=1800)
    assert "error: panda_2dof-a failed" in failed.stderr and "no luck" in failed.stderr
    assert (
        "mdnrnn@panda_2dof-a" in failed.stderr and "Running stage 'ranking@panda_2dof'" not in failed.stdout
    )


def test_another_study_touches_its_branch_and_comes_back_from_the_cache(done: Clone) -> None:
    there = exp_run(done, "-S", "viewpoint.phi=31")
    assert branch("study") | {"report"} <= there <= branch("study") | FAN_IN
    former = PARAMS["viewpoint"]["phi"]
    assert exp_run(done, "-S", f"viewpoint.phi={former}") == set()
    assert done.run("git", "status", "--porcelain", "dvc.lock", "reports").stdout == ""


def test_another_candidate_touches_its_branch_only(done: Clone) -> None:
    there = exp_run(done, "-S", "viewpoints.fetch_reach-c.phi=21")
    assert branch("fetch_reach-c") <= there <= branch("fetch_reach-c") | FAN_IN
    done.run("git", "checkout", "--quiet", ".")
    done.run("dvc", "checkout", "--quiet")


# What the stand-in of a stage writes does not depend on parameters: the stages after it do not change.
MODELS = {f"{stage}@study" for stage in ("frames", "vae", "latents", "mdnrnn")}


@pytest.mark.parametrize(
    ("change", "target", "least", "most"),
    [
        ("viewpoint.phi=31", (), branch("study") | {"report"}, branch("study") | FAN_IN),
        ("controller.sigma=0.05", ("evaluation@study",), MODELS | {"controller@study"}, set()),
        ("mdnrnn.gradient_norm=2.0", ("evaluation@study",), MODELS, set()),
    ],
)
def test_a_fresh_clone_computes_what_changed_and_what_that_reads(
    done: Clone, tmp_path: Path, change: str, target: tuple[str, ...], least: set[str], most: set[str]
) -> None:
    done.run("git", "clone", "--quiet", done.root, tmp_path / "fresh clone")
    fresh = Clone(tmp_path / "fresh clone")
    fresh.lend_environment()
    there = exp_run(fresh, "--allow-missing", "-S", change, *target)
    drawn = {f"{stage}@{PARAMS['viewpoint']['scene']}" for stage in ("scene", "rollouts")}
    assert least | drawn <= there <= least | most | drawn


def test_a_finer_answer_in_a_fresh_clone_runs_no_branch(done: Clone, tmp_path: Path) -> None:
    done.run("git", "clone", "--quiet", done.root, tmp_path / "fresh clone")
    fresh = Clone(tmp_path / "fresh clone")
    fresh.lend_environment()
    there = exp_run(fresh, "--allow-missing", "-S", "ranking.tolerance=0.02")
    assert "report" in there and there <= FAN_IN
