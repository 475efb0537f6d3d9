"""Which stages go together, on the real dvc.yaml as DVC reads it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from runner.plan import Job, Pipeline, branches, jobs, read_pipeline
from tests.support import ROOT, Clone

PARAMS = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
BRANCHES = {"study", *PARAMS["viewpoints"]}
FAN_IN = {f"ranking@{scene}" for scene in PARAMS["scenes"]} | {"alignment", "report"}


@pytest.fixture(autouse=True)
def root(clone: Clone, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A clone in which nothing is done, as the working directory."""
    monkeypatch.chdir(clone.root)
    monkeypatch.setenv("DVC_SITE_CACHE_DIR", str(clone.root.parent / "beside the clone"))
    return clone.root


def stages(made: Iterable[Job]) -> list[str]:
    return [stage for job in made for stage in job.stages]


def of(scene: str) -> set[str]:
    viewpoints = PARAMS["viewpoints"] | {"study": PARAMS["viewpoint"]}
    return {key for key, viewpoint in viewpoints.items() if viewpoint["scene"] == scene}


def test_every_stage_is_in_one_job_or_where_branches_meet() -> None:
    pipeline = read_pipeline([])
    made = jobs(pipeline, branches())
    assert sorted([*stages(made), *FAN_IN]) == sorted(pipeline.waits)
    shared = {f"{stage}@{scene}" for stage in ("rollouts", "anchors") for scene in PARAMS["scenes"]}
    assert {job.name for job in made} == BRANCHES | shared
    assert [job.name for job in made][:2] == [f"rollouts@{PARAMS['viewpoint']['scene']}", "study"]


def test_a_job_waits_for_all_that_its_stages_need() -> None:
    pipeline = read_pipeline([])
    made = {job.name: job for job in jobs(pipeline, branches())}
    for job in made.values():
        known = set(stages(made[name] for name in job.after))
        for stage in job.stages:
            assert set(pipeline.waits[stage]) <= known
            known.add(stage)


def test_a_target_brings_its_scene_only() -> None:
    made = jobs(read_pipeline(["ranking@panda_1dof"]), branches())
    assert {job.name for job in made} == of("panda_1dof") | {"rollouts@panda_1dof", "anchors@panda_1dof"}


def test_a_target_within_a_branch_brings_no_more_than_it_needs() -> None:
    made = jobs(read_pipeline(["latents@study"]), branches())
    scene = PARAMS["viewpoint"]["scene"]
    assert stages(made) == [f"rollouts@{scene}", "frames@study", "vae@study", "latents@study"]


def test_what_is_done_gets_no_process() -> None:
    waits = read_pipeline([]).waits
    assert jobs(Pipeline(waits, frozenset()), branches()) == []
    (alone,) = jobs(Pipeline(waits, frozenset({"vae@fetch_reach-c"})), branches())
    assert alone.name == "fetch_reach-c" and alone.after == frozenset()
    made = jobs(Pipeline(waits, frozenset({"rollouts@fetch_reach"})), branches())
    assert {job.name for job in made} == of("fetch_reach") | {"rollouts@fetch_reach"}


@pytest.mark.parametrize("target", ["ranking@nowhere", "rankings"])
def test_an_unknown_target_is_told(target: str) -> None:
    with pytest.raises(BelvedereError, match=target):
        read_pipeline([target])


def test_a_broken_dvc_yaml_is_told() -> None:
    Path("dvc.yaml").write_text("stages: [", encoding="utf-8")
    with pytest.raises(BelvedereError, match=r"dvc\.yaml"):
        read_pipeline([])
