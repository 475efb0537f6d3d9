"""Writing artefacts whole or not at all: write aside, then rename."""

from __future__ import annotations

import glob
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pipeline.contract.errors import BelvedereError
from pipeline.storage.disks import unwritable


@contextmanager
def writing(path: Path) -> Iterator[Path]:
    """Yields a temporary path beside ``path``; on success it replaces ``path``.

    The caller creates a file or a folder there. On any exception the temporary is removed and
    ``path`` is left as it was.

    Raises:
        BelvedereError: the folder cannot be written to, or its disk is full.
    """
    path = Path(path)
    aside = aside_of(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        remove_leftovers(path)
        _remove(aside)
    except OSError as error:
        raise _told(path, str(error.strerror)) from None
    try:
        yield aside
        _remove(path)
        os.replace(aside, path)
    except BelvedereError:
        raise
    except Exception as error:
        reason = unwritable(error)
        if reason is None:
            raise
        raise _told(path, reason) from None
    finally:
        _remove(aside)


def aside_of(path: Path) -> Path:
    """Where this process makes ``path`` before it is whole."""
    return path.with_name(f".{path.name}.{os.getpid()}.part")


def remove_leftovers(path: Path) -> None:
    """Removes what processes left of ``path`` that were killed before it was whole."""
    for left in path.parent.glob(f".{glob.escape(path.name)}.*.part"):
        process = left.name.split(".")[-2]
        if process.isdigit() and not _is_alive(int(process)):
            _remove(left)


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except PermissionError:  # somebody else's
        return True
    return True


def _told(path: Path, reason: str) -> BelvedereError:
    return BelvedereError(
        f"cannot write {path} ({reason}); {path.parent} has to be a writable folder with space."
    )


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes ``content`` as JSON that is stable byte for byte (NaN and infinity are refused)."""
    with writing(path) as aside:
        aside.write_text(
            json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n",
            encoding="utf-8",
        )


def read_json(path: Path, made_by: str) -> dict[str, Any]:
    """Reads a JSON object.

    Args:
        path: the file.
        made_by: the stage that writes it, named when it is missing or foreign.
    """
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BelvedereError(f"{path} is missing; `dvc repro {made_by}` makes it.") from None
    except (json.JSONDecodeError, UnicodeDecodeError):
        raise BelvedereError(f"{path} is no JSON file; delete it and run `dvc repro {made_by}`.") from None
    if not isinstance(content, dict):
        raise BelvedereError(f"{path} holds no JSON object; `dvc repro {made_by}` makes it again.")
    return content
