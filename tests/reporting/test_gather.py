"""Experiments of a small DVC repository, gathered into the table of viewpoints tried."""

from __future__ import annotations

import polars as pl
import pytest
import yaml

from pipeline.contract.artefacts import write_json
from tests.support import ROOT, Clone

VIEWPOINT = {"scene": "panda_2dof", "theta": 45.0, "phi": 15.0}
STAGE = """
import json, pathlib, yaml
view = yaml.safe_load(open("params.yaml"))["viewpoint"]
out = pathlib.Path("reports/branches/panda_2dof/study/evaluation.json")
out.parent.mkdir(parents=True, exist_ok=True)
repeats = [{"repeat": r, "return": -view["phi"] / 10 - r} for r in range(2)]
angles = {"theta_deg": view["theta"], "phi_deg": view["phi"]}
out.write_text(json.dumps({"scene": "panda_2dof", **angles, "repeats": repeats}))
"""


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Clone:
    """A repository whose one stage leaves a study's evaluation, with four experiments."""
    made = Clone(tmp_path_factory.mktemp("sweep") / "a study")
    made.root.mkdir()
    out = "reports/branches/panda_2dof/study/evaluation.json"
    stage = {"cmd": "python stage.py", "params": ["viewpoint", "seed"], "metrics": [{out: {"cache": False}}]}
    (made.root / "dvc.yaml").write_text(yaml.safe_dump({"stages": {"evaluation": stage}}))
    (made.root / "stage.py").write_text(STAGE)
    tree = {"budget": "tiny", "seed": 1, "viewpoint": VIEWPOINT}
    (made.root / "params.yaml").write_text(yaml.safe_dump(tree))
    write_json(made.root / "reports/anchors/panda_2dof.json", {"blind_mean": -10.0, "expert_mean": 0.0})
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
    return made


def gather(repository: Clone, status: int = 0) -> str:
    words = ("python", "-m", "pipeline.reporting.gather", "--out", "data/tried.csv")
    return repository.run(*words, status=status, PYTHONPATH=str(ROOT)).stderr


def test_experiments_that_differ_in_their_viewpoint_are_gathered(repository: Clone) -> None:
    said = gather(repository)
    assert "left out: other has another seed in params.yaml" in said
    table = pl.read_csv(repository.root / "data/tried.csv").sort("phi_deg", "repeat")
    (one,) = set(table["experiment"][:2]) & {"low", "twin"}  # the same viewpoint, and so the same trainings
    assert f"left out: {'twin' if one == 'low' else 'low'} has the viewpoint of another" in said
    assert table["experiment"].to_list() == [one, one, "high", "high"]
    assert table["phi_deg"].to_list() == [5.0, 5.0, 40.0, 40.0]
    assert table["score"].to_list() == pytest.approx([0.95, 0.85, 0.6, 0.5])
    assert set(table["budget"]) == {"tiny"}
