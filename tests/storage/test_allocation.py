"""How many repeats a branch has: its own entry where that counts, else its scene's."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.viewpoints import Viewpoint
from pipeline.storage.allocation import (
    ALLOCATION_FILE,
    Allocation,
    Entry,
    branch_repeats,
    read_allocation,
    scene_repeats,
    write_allocation,
)

PARAMS = "{seed: 7, budget: small, budgets: {small: {race: {first: 2, most: 9}}}}"
VIEW = {"scene": "near", "theta": 30.0, "phi": 7.5}
HERE, FIRST = Viewpoint(**VIEW), 2


@pytest.fixture(autouse=True)
def allocation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Allocation:
    monkeypatch.chdir(tmp_path)
    Path("params.yaml").write_text(PARAMS)
    branches = {"near-a": Entry(**VIEW, repeats=3), "far-a": Entry(scene="far", theta=0, phi=0, repeats=6)}
    written = Allocation(budget="small", seed=7, scenes={"near": 5, "far": 6}, branches=branches)
    write_allocation(written)
    return written


def test_what_is_written_comes_back_and_is_the_same_bytes(allocation: Allocation) -> None:
    assert read_allocation() == allocation
    text = ALLOCATION_FILE.read_bytes()
    write_allocation(read_allocation())
    assert ALLOCATION_FILE.read_bytes() == text
    assert b"theta: 30, phi: 7.5," in text  # as people write it


def test_a_branch_has_its_own_and_a_scene_the_most() -> None:
    assert branch_repeats("near-a", HERE, FIRST) == 3
    far = Viewpoint(scene="far", theta=0, phi=0)
    assert branch_repeats("far-a", far, FIRST) == scene_repeats("far") == 6


@pytest.mark.parametrize("change", [{"theta": 31.0}, {"phi": 7.0}, {"scene": "far"}])
def test_another_viewpoint_has_as_many_as_its_scene(change: dict) -> None:
    view = Viewpoint(**(VIEW | change))
    assert branch_repeats("near-a", view, FIRST) == scene_repeats(view.scene)
    assert branch_repeats("new", view, FIRST) == scene_repeats(view.scene)


@pytest.mark.parametrize(("old", "new"), [("seed: 7", "seed: 8"), ("small", "large")])
def test_entries_for_another_seed_or_budget_do_not_count(old: str, new: str) -> None:
    Path("params.yaml").write_text(PARAMS.replace(old, new))
    assert branch_repeats("near-a", HERE, FIRST) == scene_repeats("far") == 2


def test_nobody_has_fewer_than_the_first_repeats() -> None:
    Path("params.yaml").write_text(PARAMS.replace("first: 2", "first: 4"))
    assert branch_repeats("near-a", HERE, 4) == 4
    assert branch_repeats("near-a", HERE, 1) == 3
    assert scene_repeats("elsewhere") == 4
    own = "first: 2, scenes: {elsewhere: {first: 3}}"
    Path("params.yaml").write_text(PARAMS.replace("first: 2", own))
    assert (scene_repeats("elsewhere"), branch_repeats("near-a", HERE, FIRST)) == (3, 3)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("repeats: 3", "repeats: 0", r"branches\.near-a\.repeats = 0"),
        ("repeats: 3", "repeats: many", r"branches\.near-a\.repeats = 'many'"),
        ("seed: 7\n", "", "seed"),
        ("scenes:", "scene:", "scene"),
    ],
)
def test_a_bad_file_is_told_in_a_sentence(old: str, new: str, told: str) -> None:
    text = ALLOCATION_FILE.read_text()
    assert old in text
    ALLOCATION_FILE.write_text(text.replace(old, new, 1))
    with pytest.raises(BelvedereError, match=f"data/allocation.yaml: .*{told}"):
        branch_repeats("near-a", HERE, FIRST)


def test_a_missing_file_says_who_writes_it() -> None:
    ALLOCATION_FILE.unlink()
    with pytest.raises(BelvedereError, match=r"data/allocation\.yaml is missing; `\./run` writes it"):
        scene_repeats("near")
