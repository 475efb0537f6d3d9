"""Which stages go together, on the real dvc.yaml as DVC reads it."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest
import yaml

from pipeline.contract.declared import branches
from pipeline.contract.errors import BelvedereError
from runner.plan import Job, Pipeline, jobs, read_pipeline
from tests.support import ROOT, Clone

PARAMS = yaml.safe_load((ROOT / "params.yaml").read_text(encoding="utf-8"))
BRANCHES = {"study", *PARAMS["viewpoints"]}
SCENE_STAGES = ("scene", "rollouts", "anchors", "ranking")
SHARED = {f"{stage}@{scene}" for stage in SCENE_STAGES for scene in PARAMS["scenes"]}
FAN_IN = {"trials", "people", "report"}


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


def test_every_stage_is_in_one_job_or_where_scenes_meet() -> None:
    pipeline = read_pipeline(["dvc.yaml"])
    made = jobs(pipeline, branches(), 0)
    assert sorted([*stages(made), *FAN_IN]) == sorted(pipeline.waits)
    assert {job.name for job in made} == BRANCHES | SHARED


def test_a_job_waits_for_all_that_its_stages_need() -> None:
    pipeline = read_pipeline(["dvc.yaml"])
    made = {job.name: job for job in jobs(pipeline, branches(), 0)}
    for job in made.values():
        known = set(stages(made[name] for name in job.after))
        for stage in job.stages:
            assert set(pipeline.waits[stage]) <= known
            known.add(stage)


def test_a_target_brings_its_scene_only() -> None:
    made = jobs(read_pipeline(["ranking@panda_1dof"]), branches(), 3)
    shared = {f"{stage}@panda_1dof" for stage in SCENE_STAGES}
    assert {job.name for job in made} == of("panda_1dof") | shared
    assert {job.place for job in made} == {3}


def test_what_depends_on_the_number_of_repeats_is_known() -> None:
    pipeline = read_pipeline(["dvc.yaml"])
    episodes = {f"rollouts@{scene}" for scene in PARAMS["scenes"]}
    assert pipeline.allocated == episodes | {f"frames@{key}" for key in BRANCHES}


def test_what_is_done_gets_no_process() -> None:
    waits = read_pipeline(["dvc.yaml"]).waits

    def made(*changed: str) -> dict[str, Job]:
        found = jobs(Pipeline(waits, frozenset(changed), frozenset()), branches(), 0)
        return {job.name: job for job in found}

    assert made() == {}
    alone = made("vae@fetch_reach-c")
    assert set(alone) == {"fetch_reach-c", "ranking@fetch_reach"}
    assert alone["fetch_reach-c"].after == frozenset()
    assert alone["ranking@fetch_reach"].after == {"fetch_reach-c"}
    every = of("fetch_reach") | {"rollouts@fetch_reach", "ranking@fetch_reach"}
    assert set(made("rollouts@fetch_reach")) == every


def test_a_round_is_of_its_viewpoints_only() -> None:
    pipeline = read_pipeline(["dvc.yaml"])
    own = pipeline.of({"fetch_reach", "fetch_reach-a", "fetch_reach-d"}, pipeline.allocated)
    made = {job.name: job.after for job in jobs(own, branches(), 0)}
    assert made == {
        "rollouts@fetch_reach": frozenset(),
        "fetch_reach-a": {"rollouts@fetch_reach"},
        "fetch_reach-d": {"rollouts@fetch_reach"},
        "ranking@fetch_reach": {"fetch_reach-a", "fetch_reach-d"},
    }


@pytest.mark.parametrize("target", ["ranking@nowhere", "rankings"])
def test_an_unknown_target_is_told(target: str) -> None:
    with pytest.raises(BelvedereError, match=target):
        read_pipeline([target])


def test_a_broken_dvc_yaml_is_told() -> None:
    Path("dvc.yaml").write_text("stages: [", encoding="utf-8")
    with pytest.raises(BelvedereError, match=r"dvc\.yaml"):
        read_pipeline(["dvc.yaml"])
