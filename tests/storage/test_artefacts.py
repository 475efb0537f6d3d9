"""An artefact is there whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import read_json, write_json, writing


def test_a_failure_leaves_the_former_file_and_nothing_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("former")
    with pytest.raises(ZeroDivisionError), writing(path) as aside:
        aside.write_text("half")
        raise ZeroDivisionError
    assert [file.name for file in tmp_path.iterdir()] == ["a.txt"]
    assert path.read_text() == "former"


def test_a_failure_leaves_nothing_where_nothing_was(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), writing(tmp_path / "folder") as aside:
        aside.mkdir()
        (aside / "half").touch()
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []


def test_a_folder_takes_the_former_ones_place_entirely(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "folder"
    for name in ("one", "two"):
        with writing(path) as aside:
            aside.mkdir()
            (aside / name).touch()
    assert [file.name for file in path.iterdir()] == ["two"]
    assert list(path.parent.iterdir()) == [path]


def test_the_artefact_is_not_seen_before_it_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    with writing(path) as aside:
        aside.write_text("half")
        assert not path.exists()
    assert path.read_text() == "half"


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_json_refuses_what_is_no_number(tmp_path: Path, number: float) -> None:
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "a.json", {"loss": number})
    assert list(tmp_path.iterdir()) == []


def test_json_comes_back_and_is_stable(tmp_path: Path) -> None:
    content = {"θ": 0.1 + 0.2, "keys": ["b", "a"], "none": None}
    for name in ("a.json", "b.json"):
        write_json(tmp_path / name, content)
    assert read_json(tmp_path / "a.json", "ranking") == content
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


@pytest.mark.parametrize("content", [b"{", b"[1]", b"\xff\xfe", b""])
def test_foreign_json_names_file_and_remedy(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "a.json"
    path.write_bytes(content)
    with pytest.raises(BelvedereError, match=r"a\.json .*dvc repro ranking"):
        read_json(path, "ranking")


def test_missing_json_names_the_stage_that_makes_it(tmp_path: Path) -> None:
    with pytest.raises(BelvedereError, match=r"a\.json is missing; `dvc repro anchors` makes it"):
        read_json(tmp_path / "a.json", "anchors")


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(BelvedereError, match="cannot write"), writing(tmp_path / "file" / "a.json"):
        pass


@pytest.mark.skipif(os.geteuid() == 0, reason="not run: root may write anywhere")
def test_a_folder_without_permission_is_told(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(BelvedereError, match=r"(?i)permission denied"), writing(tmp_path / "a.json") as aside:
        aside.touch()
