"""A full disk is told in a sentence, whichever library meets it."""

from __future__ import annotations

import errno
import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from PIL import Image

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import writing
from pipeline.storage.disks import unwritable
from pipeline.storage.stage import entry

ROOT = Path(__file__).resolve().parents[2]
FULL = Path("/dev/full")
VIEW = ("--scene", "panda_2dof", "--theta", "0", "--phi", "0")
TABLE = pl.DataFrame({"a": range(10_000)})

pytestmark = pytest.mark.skipif(not FULL.exists(), reason="not run: no /dev/full")


def save_array(path: Path) -> None:
    with path.open("wb") as file:
        np.savez(file, a=np.zeros(10_000))


def copy_tree(path: Path) -> None:
    path.with_name("source").mkdir()
    path.with_name("source").joinpath("file").touch()
    shutil.copytree(path.with_name("source"), path.with_name("copy"), copy_function=lambda *_: full_write())


def full_write() -> None:
    FULL.write_bytes(bytes(10))


WRITERS: dict[str, Callable[[Path], object]] = {
    "text": lambda path: path.write_text("a" * 10_000),
    "CSV": TABLE.write_csv,
    "Parquet": TABLE.write_parquet,
    "NumPy": save_array,
    "PNG": lambda path: Image.new("RGB", (500, 500)).save(path, "png"),
    "WebP": lambda path: Image.new("RGB", (500, 500)).save(path, "webp"),
    "a tree of files": copy_tree,
}


@pytest.mark.parametrize("kind", WRITERS)
def test_an_output_for_which_there_is_no_room_is_told(kind: str, tmp_path: Path) -> None:
    output = tmp_path / "output"
    output.write_text("as it was")
    with (
        pytest.raises(BelvedereError, match=f"cannot write {output} .No space left on device.; {tmp_path}"),
        writing(output) as aside,
    ):
        aside.symlink_to(FULL)
        WRITERS[kind](aside)
    assert output.read_text() == "as it was"


@pytest.mark.parametrize("kind", WRITERS)
def test_a_cache_for_which_there_is_no_room_is_told(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "cache").symlink_to(FULL)
    with pytest.raises(SystemExit) as end:
        entry(lambda: WRITERS[kind](tmp_path / "cache"), [])
    assert end.value.code == 1
    said = capsys.readouterr().err
    assert said.startswith("error: ") and said.count("\n") == 1
    assert "No space left on device" in said and "WARP_CACHE_PATH" in said


def test_other_errors_are_none_of_the_disk() -> None:
    assert unwritable(FileNotFoundError(errno.ENOENT, "No such file or directory", "a")) is None
    assert unwritable(ValueError("a")) is None


def test_a_full_kernel_cache_is_told(tmp_path: Path) -> None:
    """Warp compiles into an empty cache; that files may not grow stands for a disk that is full."""
    done = subprocess.run(
        [sys.executable, "-m", "pipeline.rendering.preview", *VIEW, "--out", str(tmp_path / "view.png")],
        cwd=ROOT,
        env=os.environ | {"WARP_CACHE_PATH": str(tmp_path / "cache"), "BELVEDERE_SCRATCH": str(tmp_path)},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2**14, 2**14)),
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 1
    assert "File too large" in done.stderr and "WARP_CACHE_PATH" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "view.png").exists()
