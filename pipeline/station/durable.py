"""Writing that outlives a power cut: a file is on the disk before anything is built on it."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pipeline.storage.artefacts import aside_of, remove_leftovers


def write(path: Path, content: bytes) -> None:
    """Writes a file whole or not at all: aside, to the disk, renamed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    remove_leftovers(path)
    aside = aside_of(path)
    with aside.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    os.replace(aside, path)
    _sync_folder(path.parent)


def write_text(path: Path, text: str) -> None:
    """Writes a text as :func:`write` does."""
    write(path, text.encode("utf-8"))


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Writes JSON as :func:`write` does."""
    write_text(path, json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n")


def append_line(path: Path, line: str) -> None:
    """Appends a line, which is on the disk when this returns."""
    path.parent.mkdir(parents=True, exist_ok=True)
    new = not path.exists()
    with path.open("ab") as file:
        file.write(line.encode("utf-8") + b"\n")
        file.flush()
        os.fsync(file.fileno())
    if new:
        _sync_folder(path.parent)


def whole_lines(path: Path) -> list[str]:
    """A file's lines; none where there is no file.

    A last line without its end was cut off as it was written: the file is cut down to the lines before it.
    """
    if not path.exists():
        return []
    content = path.read_bytes()
    end = content.rfind(b"\n") + 1
    if end < len(content):
        with path.open("r+b") as file:
            file.truncate(end)
            file.flush()
            os.fsync(file.fileno())
        print(f"{path}: its last line was cut off as it was written, and is dropped.")
    return [line.decode("utf-8") for line in content[:end].split(b"\n") if line]


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
