"""What a finished repeat consists of: its files and their hashes, looked at before it is used."""

from __future__ import annotations

import hashlib
from pathlib import Path

from pipeline.contract.errors import BelvedereError
from pipeline.storage.artefacts import read_json, write_json

_FILE = "manifest.json"


def write_manifest(folder: Path) -> None:
    """Writes the manifest of all files below ``folder`` into it."""
    write_json(folder / _FILE, {"sha256": _hashes(folder)})


def mismatch(folder: Path) -> str | None:
    """Why ``folder`` is not what its manifest says, in a few words; None where it is."""
    try:
        listed = read_json(folder / _FILE, "").get("sha256")
    except (BelvedereError, OSError):
        return f"it has no {_FILE} that can be read"
    if not isinstance(listed, dict):
        return f"its {_FILE} lists nothing"
    found = _hashes(folder)
    differing = sorted(name for name in {**found, **listed} if found.get(name) != listed.get(name))
    return f"{differing[0]} is not as it was written" if differing else None


def _hashes(folder: Path) -> dict[str, str]:
    files = sorted(file for file in folder.rglob("*") if file.is_file() and file != folder / _FILE)
    return {file.relative_to(folder).as_posix(): _hash(file) for file in files}


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
