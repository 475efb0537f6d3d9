"""Rounds of a race, with rankings written by hand and the real dvc.yaml's shape of a scene."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from pipeline.storage.allocation import read_allocation
from runner.plan import Job, Pipeline
from runner.race import Race, allocate, soonest_answered

VIEWS = {
    "near-a": {"scene": "near", "theta": 0, "phi": 0},
    "near-b": {"scene": "near", "theta": 90, "phi": 0},
}
BRANCHES = {"study", *VIEWS}


def write_params(**change: Any) -> None:
    tree: dict[str, Any] = {
        "seed": 1,
        "budget": "small",
        "budgets": {"small": {"race": {"first": 3, "most": 8}}, "large": {"race": {"first": 4, "most": 8}}},
        "viewpoint": {"scene": "far", "theta": 45, "phi": 15},
        "viewpoints": VIEWS,
        "scenes": {"near": {}, "far": {}},
    }
    Path("params.yaml").write_text(yaml.safe_dump(tree | change))


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    write_params()
    return tmp_path


def rank(scene: str, *, open_: bool, common: int = 3, active: tuple[str, ...] = (), most: int = 8) -> None:
    race = {"open": open_, "common": common, "active": list(active)}
    ranking = {"answer": {"sentence": "Here.", "progress": f"{scene} goes on"}, "race": race, "most": most}
    path = Path(f"reports/rankings/{scene}.json")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(ranking))


def pipeline(*changed: str) -> Pipeline:
    waits: dict[str, list[str]] = {}
    for scene, keys in {"near": list(VIEWS), "far": ["study"]}.items():
        waits |= {f"rollouts@{scene}": [], f"anchors@{scene}": []}
        for key in keys:
            waits |= {f"frames@{key}": [f"rollouts@{scene}"], f"vae@{key}": [f"frames@{key}"]}
        waits[f"ranking@{scene}"] = [f"anchors@{scene}", *(f"vae@{key}" for key in keys)]
    allocated = {s for s in waits if s.startswith(("rollouts", "frames"))}
    return Pipeline(waits, frozenset(changed), frozenset(allocated))


def race(*changed: str, cores: int = 2) -> Race:
    return Race(pipeline(*changed), BRANCHES, ["near", "far"], cores, allocate())


def names(jobs: list[Job]) -> list[str]:
    return [job.name for job in jobs]


def repeats() -> dict[str, int]:
    return {key: entry.repeats for key, entry in read_allocation().branches.items()}


def test_everybody_begins_with_the_first_repeats() -> None:
    assert set(repeats_of := {k: e.repeats for k, e in allocate().branches.items()}) == BRANCHES
    assert set(repeats_of.values()) == {3} and repeats() == repeats_of


def test_the_scenes_of_fewest_trainings_are_answered_first() -> None:
    assert soonest_answered(allocate()) == ["far", "near"]  # one viewpoint, two viewpoints


def test_a_scene_may_begin_with_a_number_of_its_own() -> None:
    own = {"first": 3, "most": 8, "scenes": {"far": {"first": 2}}}
    write_params(budgets={"small": {"race": own}})
    found = allocate()
    assert found.scenes == {"near": 3, "far": 2}
    assert {k: e.repeats for k, e in found.branches.items()} == {"study": 2, "near-a": 3, "near-b": 3}


def test_what_is_not_done_is_done_first_and_a_scene_s_answer_before_the_next() -> None:
    rank("far", open_=False)
    begun = race("rollouts@near").begin()
    assert names(begun) == ["rollouts@near", "near-a", "near-b", "ranking@near"]
    assert {job.place for job in begun} == {0}


def test_when_all_is_answered_nothing_is_left() -> None:
    rank("near", open_=False)
    rank("far", open_=False)
    assert race().begin() == []


def test_a_round_gives_more_to_those_in_the_race_and_to_nobody_else(capsys: pytest.CaptureFixture) -> None:
    rank("far", open_=False)
    rank("near", open_=True, active=("near-b",), common=3)
    begun = race(cores=1).begin()
    assert names(begun) == ["rollouts@near", "near-b", "ranking@near"]
    assert repeats() == {"study": 3, "near-a": 3, "near-b": 4}
    assert read_allocation().scenes == {"near": 4, "far": 3}
    assert "near goes on" in capsys.readouterr().out


def test_a_round_follows_the_ranking_and_fills_the_cores_but_never_beyond_the_most() -> None:
    rank("far", open_=False)
    rank("near", open_=True, active=tuple(VIEWS), common=3)
    running = race("vae@near-a", cores=8)
    first = running.begin()
    assert names(first) == ["near-a", "ranking@near"]
    assert running.more(first[0]) == []
    assert names(running.more(first[1])) == ["rollouts@near", *VIEWS, "ranking@near"]
    assert repeats()["near-a"] == 3 + 8 // 2
    rank("near", open_=True, active=tuple(VIEWS), common=7)
    running.more(first[1])
    assert repeats()["near-a"] == 8


def test_a_race_that_can_get_no_more_is_told_rather_than_run_without_end() -> None:
    rank("far", open_=False)
    rank("near", open_=True, active=tuple(VIEWS), common=3, most=3)
    with pytest.raises(BelvedereError, match=r"race of near is open, but near-a, near-b have all"):
        race().begin()


def test_a_killed_run_finds_its_allocation_again() -> None:
    rank("far", open_=False)
    rank("near", open_=True, active=tuple(VIEWS))
    race().begin()
    given = repeats()
    assert race("frames@near-a").allocation.branches["near-a"].repeats == given["near-a"] > 3
    assert repeats() == given


def test_another_viewpoint_gets_as_many_as_its_scene_and_others_keep_theirs() -> None:
    rank("far", open_=False)
    rank("near", open_=True, active=("near-a",), common=3)
    race(cores=1).begin()
    write_params(viewpoint={"scene": "near", "theta": 45, "phi": 15})
    allocate()
    assert repeats() == {"study": 4, "near-a": 4, "near-b": 3}


@pytest.mark.parametrize(("change", "first"), [({"seed": 2}, 3), ({"budget": "large"}, 4)])
def test_another_seed_or_budget_begins_a_race_anew(change: dict, first: int) -> None:
    rank("far", open_=False)
    rank("near", open_=True, active=("near-a",), common=3)
    race().begin()
    write_params(**change)
    allocate()
    assert set(repeats().values()) == {first}


def test_branches_come_and_go() -> None:
    allocate()
    write_params(viewpoints={"near-a": VIEWS["near-a"], "near-z": {"scene": "near", "theta": 10, "phi": 2.5}})
    allocate()
    assert set(repeats()) == {"study", "near-a", "near-z"}


@pytest.mark.parametrize("part", ["answer", "race", "most"])
def test_a_ranking_that_lacks_a_part_is_told_with_its_remedy(part: str) -> None:
    rank("near", open_=False)
    path = Path("reports/rankings/near.json")
    path.write_text(json.dumps({k: v for k, v in json.loads(path.read_text()).items() if k != part}))
    race = Race(pipeline(), BRANCHES, ["near"], 2, allocate())
    with pytest.raises(BelvedereError, match=rf"near\.json: {part} is not valid .*`dvc repro ranking@near`"):
        race.next_round("near")
