"""Recordings and git: none gets in by accident, and `dvc add` works as docs/people.md says."""

from __future__ import annotations

import pytest

from tests.study.sessions import write_sessions
from tests.support import Clone

FOLDER = "data/study"
BELONGS = {f"{FOLDER}/README", f"{FOLDER}/dataset_description.json"}


@pytest.fixture
def recorded(clone: Clone) -> tuple[Clone, list[str]]:
    """A clone with recorded sessions, all kinds of files among them."""
    names = write_sessions(clone.root / FOLDER, people=2, seed=1, scenes=1)
    (clone.root / FOLDER / "participants.json").write_text("{}")
    for name in names:
        beh = clone.root / FOLDER / name / "beh"
        for file in ("plan.json", "events.jsonl", "practice.jsonl", "trial-001_attempt-1_trajectory.parquet"):
            (beh / f"{name}_ses-01_{file}").write_text("{}\n")
    demonstration = clone.root / "data/demonstration"
    write_sessions(demonstration, people=1, seed=2, scenes=1)
    return clone, names


def of_study(clone: Clone) -> set[str]:
    return set(clone.run("git", "ls-files", FOLDER, "data/demonstration").stdout.split())


def test_a_plain_git_add_takes_no_recording(recorded: tuple[Clone, list[str]]) -> None:
    clone, _ = recorded
    clone.run("git", "add", ".")
    clone.run("git", "add", "--all", ".")
    assert of_study(clone) == BELONGS
    assert clone.run("git", "status", "--porcelain").stdout == ""
    told = clone.run("git", "add", f"{FOLDER}/participants.tsv", status=1)
    assert "ignored" in told.stderr


def test_dvc_add_tracks_a_participant_as_the_docs_say(recorded: tuple[Clone, list[str]]) -> None:
    clone, names = recorded
    clone.run("dvc", "init", "--quiet", "--force")
    places = [f"{FOLDER}/participants.tsv", *(f"{FOLDER}/{name}" for name in names)]
    clone.run("dvc", "add", *places)
    clone.run("git", "add", ".")
    clone.run("git", "add", *(f"{place}.dvc" for place in places))
    assert of_study(clone) == BELONGS | {f"{place}.dvc" for place in places}
    clone.run("git", "commit", "--quiet", "--message", "what DVC tracks")
    before = {
        path: path.read_bytes() for path in (clone.root / FOLDER / names[0]).rglob("*") if path.is_file()
    }
    clone.run("rm", "-r", *(clone.root / place for place in places))
    clone.run("dvc", "checkout", "--quiet", *(f"{place}.dvc" for place in places))
    assert before and {path: path.read_bytes() for path in before} == before
