"""Experiments of a small DVC repository, gathered into the table of viewpoints tried."""

from __future__ import annotations

import time
from pathlib import Path

import polars as pl
import pytest
import yaml

from tests.support import ROOT, Clone

VIEWPOINT = {"scene": "panda_2dof", "theta": 45.0, "phi": 15.0}
STAGE = """
import json, pathlib, sys
theta, phi = map(float, sys.argv[1:])
if phi == 66:
    sys.exit("no luck")
out = pathlib.Path("reports/branches/panda_2dof/study/evaluation.json")
out.parent.mkdir(parents=True, exist_ok=True)
repeats = [{"repeat": r, "return": -phi / 10 - r} for r in range(2)]
out.write_text(json.dumps({"scene": "panda_2dof", "theta_deg": theta, "phi_deg": phi, "repeats": repeats}))
"""
ANCHORS = """
import pathlib
out = pathlib.Path("reports/anchors/panda_2dof.json")
out.parent.mkdir(parents=True, exist_ok=True)
out.write_text('{"blind_mean": -10.0, "expert_mean": 0.0}')
"""
PARAMS = {
    "budget": "tiny",
    "budgets": {"tiny": {"race": {"first": 2, "most": 2}}},
    "seed": 1,
    "heldout_share": 0.1,
    "sight_share": 0.5,
    "rollouts": {},
    "vae": {},
    "mdnrnn": {},
    "controller": {},
    "scenes": {"panda_2dof": {}},
    "viewpoint": VIEWPOINT,
}
EVALUATION, LEVELS = "reports/branches/panda_2dof/study/evaluation.json", "reports/anchors/panda_2dof.json"


def stages() -> dict[str, object]:
    evaluation = {
        "cmd": "python stage.py ${item.theta} ${item.phi}",
        "deps": ["stage.py"],
        "params": ["seed"],
        "metrics": [{EVALUATION: {"cache": False}}],
    }
    anchors = {"cmd": "python anchors.py", "deps": ["anchors.py"], "metrics": [{LEVELS: {"cache": False}}]}
    return {
        "evaluation": {"foreach": {"study": "${viewpoint}"}, "do": evaluation},
        "anchors": {"foreach": "${scenes}", "do": anchors},
    }


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Clone:
    """A repository whose stages leave a study's evaluation and anchors, with experiments of every sort."""
    made = Clone(tmp_path_factory.mktemp("sweep") / "a study")
    made.root.mkdir()
    (made.root / "dvc.yaml").write_text(yaml.safe_dump({"stages": stages()}, sort_keys=False))
    (made.root / "stage.py").write_text(STAGE)
    (made.root / "anchors.py").write_text(ANCHORS)
    (made.root / "params.yaml").write_text(yaml.safe_dump(PARAMS))
    made.run("git", "init", "--quiet", "--initial-branch", "main")
    made.run("dvc", "init", "--quiet")
    made.commit("as it is")
    made.run("dvc", "repro", "--quiet")
    made.commit("its results")
    for name, change in (
        ("low", "viewpoint.phi=5"),
        ("high", "viewpoint.phi=40"),
        ("twin", "viewpoint.phi=5"),
        ("other", "seed=2"),
    ):
        made.run("dvc", "exp", "run", "--quiet", "--name", name, "--set-param", change)
        made.run("git", "checkout", "--quiet", "--", ".")
    save(made, "moved", "params.yaml", "phi: 15.0", "phi: 70.0")  # and not run
    save(made, "edited", "stage.py", "/ 10", "/ 20")  # and not run
    with_other_code = (made.root / "stage.py").read_text().replace("/ 10", "/ 20")
    (made.root / "stage.py").write_text(with_other_code)
    made.run("dvc", "exp", "run", "--quiet", "--name", "recoded", "--set-param", "viewpoint.phi=50")
    made.run("git", "checkout", "--quiet", "--", ".")
    forge(made)
    return made


def forge(repository: Clone) -> None:
    """An experiment in which results and viewpoint agree, and its dvc.lock with neither."""
    for name in ("params.yaml", EVALUATION):
        path = repository.root / name
        path.write_text(path.read_text().replace("15.0", "75.0"))
    baseline = repository.run("git", "rev-parse", "HEAD").stdout.strip()
    repository.commit("as if it had run")
    repository.run("git", "update-ref", f"refs/exps/{baseline[:2]}/{baseline[2:]}/forged", "HEAD")
    repository.run("git", "reset", "--quiet", "--hard", baseline)


def save(repository: Clone, name: str, file: str, old: str, new: str) -> None:
    """Changes a file and saves the working tree as an experiment, with the results of before."""
    path = repository.root / file
    assert path.read_text().count(old) == 1
    path.write_text(path.read_text().replace(old, new))
    repository.run("dvc", "exp", "save", "--quiet", "--name", name)
    repository.run("git", "checkout", "--quiet", "--", ".")


def gather(repository: Clone, status: int = 0) -> str:
    words = ("python", "-m", "pipeline.reporting.gather", "--out", "data/tried.csv")
    return repository.run(*words, status=status, PYTHONPATH=str(ROOT)).stderr


def rows(repository: Clone) -> list[tuple[str, float, int, float]]:
    table = pl.read_csv(repository.root / "data/tried.csv").sort("phi_deg", "repeat")
    assert set(table["budget"]) == {"tiny"} and table["parameters"].n_unique() == 1
    return table.select("experiment", "phi_deg", "repeat", "score").rows()


GATHERED = [
    ("low", 5.0, 0, pytest.approx(0.95)),
    ("low", 5.0, 1, pytest.approx(0.85)),
    ("high", 40.0, 0, pytest.approx(0.6)),
    ("high", 40.0, 1, pytest.approx(0.5)),
]
LEFT_OUT = [
    "edited was made by another stage.py than there is here",
    "forged has not run evaluation@study with the parameters and code of its own revision",
    "moved has a reports/branches/panda_2dof/study/evaluation.json of ('panda_2dof', 45.0, 15.0), though its "
    "viewpoint is ('panda_2dof', 45.0, 70.0)",
    "other has another seed in params.yaml",
    "recoded was made by another stage.py than there is here",
    "twin has the viewpoint of low",
]


def test_experiments_that_differ_in_their_viewpoint_are_gathered_and_no_others(repository: Clone) -> None:
    assert gather(repository).splitlines() == [f"left out: {line}" for line in LEFT_OUT]
    assert rows(repository) == GATHERED


def test_queued_and_failed_experiments_are_left_out_until_they_ended_with_success(repository: Clone) -> None:
    """Their revisions hold the baseline's results."""
    for name, phi in (("waits", 30), ("fails", 66)):
        run = ("dvc", "exp", "run", "--quiet", "--queue", "--name", name, "-S", f"viewpoint.phi={phi}")
        repository.run(*run)
    told = gather(repository)
    assert "left out: waits is queued" in told and "left out: fails is queued" in told
    assert rows(repository) == GATHERED
    repository.run("dvc", "queue", "start", "--quiet")
    begun = time.monotonic()
    while {"Queued", "Running"} & set(repository.run("dvc", "queue", "status").stdout.split()):
        assert time.monotonic() - begun < 120
        time.sleep(0.5)
    told = gather(repository)
    assert "left out: fails is failed" in told and "waits" not in told
    assert [row[:3] for row in rows(repository)][2:4] == [("waits", 30.0, 0), ("waits", 30.0, 1)]


def test_an_experiment_pulled_from_another_clone_is_gathered(repository: Clone, tmp_path: Path) -> None:
    repository.run("git", "clone", "--quiet", repository.root, tmp_path / "another")
    another = Clone(tmp_path / "another")
    another.run("dvc", "exp", "pull", "--quiet", "--no-cache", "origin", "high")
    assert gather(another) == ""
    assert rows(another) == GATHERED[2:]


def test_anchors_of_other_code_are_refused(repository: Clone) -> None:
    before = (repository.root / "data/tried.csv").read_bytes()
    (repository.root / "anchors.py").write_text(ANCHORS.replace("-10.0", "-20.0"))
    told = gather(repository, status=1)
    repository.run("git", "checkout", "--quiet", "--", ".")
    assert "reports/anchors/panda_2dof.json is of other parameters or code" in told
    assert "`dvc repro anchors@panda_2dof`" in told
    assert (repository.root / "data/tried.csv").read_bytes() == before
