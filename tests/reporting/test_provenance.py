"""Where results come from."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from pipeline.reporting.provenance import costs, flat, revision
from pipeline.storage.artefacts import write_json


def _git(folder: Path, *arguments: str) -> str:
    who = ["-c", "user.name=Tester", "-c", "user.email=tester@example.org"]
    done = subprocess.run(
        ["git", "-C", str(folder), *who, *arguments], check=True, capture_output=True, text=True
    )
    return done.stdout.strip()


def test_revision_says_when_code_differs_from_it(tmp_path: Path) -> None:
    (tmp_path / "params.yaml").write_text("seed: 1\n")
    _git(tmp_path, "init")
    _git(tmp_path, "add", ".")
    _git(tmp_path, "commit", "-m", "first")
    head = _git(tmp_path, "rev-parse", "HEAD")
    (tmp_path / "dvc.lock").write_text("outputs change in every run")
    assert revision(tmp_path) == head
    (tmp_path / "params.yaml").write_text("seed: 2\n")
    assert revision(tmp_path).startswith(f"{head} with uncommitted changes")


def test_no_repository_is_no_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    assert revision(tmp_path) == "not under git"


def test_parameters_become_dotted_rows() -> None:
    assert flat({"quick": {"vae": {"epochs": 20}, "repeats": 3}, "ratio": None}) == [
        ("quick.vae.epochs", "20"),
        ("quick.repeats", "3"),
        ("ratio", "null"),
    ]


def test_damaged_records_are_passed_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("BELVEDERE_SCRATCH", str(tmp_path))
    write_json(tmp_path / "seconds" / "a.json", {"stage": "vae@study"})
    (tmp_path / "seconds" / "b.json").write_text("{")
    found = costs([])
    assert (found.rows, found.machines, found.total_s) == ({}, (), 0)
