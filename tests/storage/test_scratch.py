"""The scratch store's key is what decides the result, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.storage import scratch


@pytest.fixture(autouse=True)
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv(scratch.ENVIRONMENT_VARIABLE, str(tmp_path / "store"))
    return tmp_path / "store"


def test_the_same_decisions_find_the_same_folder(store: Path) -> None:
    first = scratch.folder("vae", 1, inputs="abc", params={"b": 1, "a": 2})
    assert first == scratch.folder("vae", 1, params={"a": 2, "b": 1}, inputs="abc")
    assert first.is_dir() and first.is_relative_to(store) and list(first.iterdir()) == []


def test_every_decision_counts() -> None:
    folders = {
        scratch.folder("vae", 1, inputs="abc"),
        scratch.folder("vae", 2, inputs="abc"),
        scratch.folder("vae", 1, inputs="abd"),
        scratch.folder("vae", 1, inputs="abc", code="x"),
        scratch.folder("mdnrnn", 1, inputs="abc"),
    }
    assert len(folders) == 5


def test_without_the_variable_the_store_is_in_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(scratch.ENVIRONMENT_VARIABLE)
    monkeypatch.chdir(tmp_path)
    assert scratch.root() == tmp_path / ".scratch"


def test_a_store_that_cannot_be_written_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(scratch.ENVIRONMENT_VARIABLE, str(tmp_path / "file"))
    with pytest.raises(BelvedereError, match=f"cannot be written to .* set {scratch.ENVIRONMENT_VARIABLE}"):
        scratch.folder("vae", 0)


def test_the_digest_of_files_tells_names_and_contents(tmp_path: Path) -> None:
    folder = tmp_path / "code"
    folder.mkdir()
    (folder / "a.py").write_text("1")
    first = scratch.digest_files([folder])
    folder.rename(tmp_path / "elsewhere")
    assert scratch.digest_files([tmp_path / "elsewhere"]) == first
    (tmp_path / "elsewhere").rename(folder)
    (folder / "a.py").write_text("2")
    second = scratch.digest_files([folder])
    (folder / "a.py").rename(folder / "b.py")
    assert len({first, second, scratch.digest_files([folder])}) == 3
