"""Rounds of a search, with what its stage says written by hand."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest
import yaml

from pipeline.contract.errors import BelvedereError
from pipeline.storage.allocation import read_allocation
from runner.plan import Job, Pipeline
from runner.race import allocate, soonest_answered
from runner.search import Search, main, stage, with_repeats

SCENE = "near"
CAMERA = {"distance_m": 1.4, "fov_deg": 40}
CANDIDATES = {f"near-c0{n}": {"scene": SCENE, "theta": 10 * n, "phi": 20, **CAMERA} for n in range(1, 5)}
PREFIX = "search/dvc.yaml:"


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    tree: dict[str, Any] = {
        "seed": 1,
        "budget": "small",
        "budgets": {"small": {"race": {"first": 3, "most": 8}}},
        "viewpoint": {"scene": "near", "theta": 45, "phi": 15},
        "viewpoints": {"near-a": {"scene": "near", "theta": 0, "phi": 0}},
        "scenes": {"near": {}, "far": {}},
        "searches": {"near": {}},
    }
    Path("params.yaml").write_text(yaml.safe_dump(tree))
    Path("search").mkdir()
    Path("search/candidates.yaml").write_text(yaml.safe_dump({"candidates": CANDIDATES, "ruled_out": {}}))


def found(
    needed: dict[str, int], *, raced: bool = False, most_repeats: int = 20, left: int | None = None
) -> None:
    said = {
        "answer": {"sentence": "Here."} if raced or not needed else None,
        "progress": "near goes on",
        "open": bool(needed),
        "needed": needed,
        "finalists": [],
        "most_repeats": most_repeats,
        "trainings_left": left,
        "trainings": 4,
    }
    path = Path(f"search/found/{SCENE}.json")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(said))


def pipeline(*changed: str) -> Pipeline:
    waits: dict[str, list[str]] = {"rollouts@near": [], "anchors@near": []}
    for key in CANDIDATES:
        waits |= {f"{PREFIX}frames@{key}": ["rollouts@near"], f"{PREFIX}vae@{key}": [f"{PREFIX}frames@{key}"]}
    waits[stage(SCENE)] = ["anchors@near", *(f"{PREFIX}vae@{key}" for key in CANDIDATES)]
    allocated = {s for s in waits if "frames@" in s or "rollouts@" in s}
    return Pipeline(waits, frozenset(changed), frozenset(allocated))


def search(*changed: str, cores: int = 2, until_s: float | None = None) -> Search:
    return Search(pipeline(*changed), SCENE, list(CANDIDATES), cores, until_s, allocate())


def names(jobs: list[Job]) -> set[str]:
    return {job.name for job in jobs}


def test_a_candidate_begins_with_one_repeat_and_a_branch_with_the_first() -> None:
    found_ = allocate()
    assert {found_.branches[key].repeats for key in CANDIDATES} == {1}
    assert {found_.branches[key].repeats for key in ("near-a", "study")} == {3}
    assert allocate() == found_ == read_allocation()


def test_candidates_do_not_put_off_the_scenes_of_a_run() -> None:
    """The order of answers goes by the trainings of the branches that are raced."""
    given = with_repeats(allocate(), SCENE, dict.fromkeys(CANDIDATES, 8))
    assert soonest_answered(given) == soonest_answered(allocate())


def test_what_was_never_run_is_begun_and_log_files_have_no_folder_in_their_names() -> None:
    everything = search(*pipeline().waits).begin()
    assert names(everything) == {"rollouts@near", "anchors@near", "search@near", *CANDIDATES}
    last = next(job for job in everything if job.name == "search@near")
    assert last.after == {"anchors@near", *CANDIDATES} and last.stages == (stage(SCENE),)


def test_a_round_of_halving_gives_one_more_to_those_that_are_left() -> None:
    found({"near-c01": 2, "near-c03": 2})
    round_ = search(cores=16).begin()
    assert names(round_) == {"rollouts@near", "near-c01", "near-c03", "search@near"}
    repeats = {key: one.repeats for key, one in read_allocation().branches.items()}
    assert (repeats["near-c01"], repeats["near-c02"], repeats["near-c03"]) == (2, 1, 2)


def test_a_round_of_the_race_fills_the_cores() -> None:
    found({"near-c01": 5, "near-c03": 5}, raced=True)
    search(cores=8).begin()
    assert read_allocation().branches["near-c01"].repeats == 8
    assert read_allocation().scenes["near"] == 8


@pytest.mark.parametrize(
    ("limits", "repeats"),
    [({"most_repeats": 6}, 6), ({"left": 4}, 6), ({"left": 1}, 5), ({"left": None}, 12)],
)
def test_cores_take_neither_more_repeats_nor_more_trainings_than_there_may_be(
    limits: dict[str, Any], repeats: int
) -> None:
    found({"near-c01": 5, "near-c03": 5}, raced=True, **limits)
    search(cores=16).begin()
    assert {read_allocation().branches[f"near-c0{n}"].repeats for n in (1, 3)} == {repeats}


@pytest.mark.parametrize("hours", ["0", "-1", "nan", "inf", "two"])
def test_hours_that_are_none_are_told(hours: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["near", "--hours", hours])
    assert f"invalid hours value: '{hours}'" in capsys.readouterr().err


def test_rounds_follow_each_other_until_it_is_closed(capsys: pytest.CaptureFixture[str]) -> None:
    going = search("anchors@near")
    (first, *_) = going.begin()
    assert going.more(first) == []
    found({"near-c02": 2})
    end = Job("search@near", (stage(SCENE),), frozenset(), 0)
    assert "near-c02" in names(going.more(end))
    found({})
    assert going.more(end) == []
    assert capsys.readouterr().out.count("near goes on") == 2


def test_after_the_hours_no_round_is_begun() -> None:
    found({"near-c02": 2})
    going = search(until_s=time.monotonic() - 1)
    assert going.begin() == [] and going.late
    assert read_allocation().branches["near-c02"].repeats == 1


def test_a_search_that_asks_for_what_it_has_is_told_instead_of_going_round() -> None:
    found({"near-c02": 1})
    with pytest.raises(
        BelvedereError, match=r"needs more repeats of near-c02.*dvc repro search/dvc.yaml:search@near"
    ):
        search().begin()


def test_a_damaged_result_is_told() -> None:
    path = Path("search/found/near.json")
    path.parent.mkdir(parents=True)
    path.write_text('{"open": true}')
    with pytest.raises(BelvedereError, match=r"near.json: \w+ is not valid.*search@near"):
        search().begin()


def test_a_scene_without_a_search_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("runner.search.check_parameters", lambda: None)
    with pytest.raises(BelvedereError, match=r"'far'.*near"):
        main(["far"])
