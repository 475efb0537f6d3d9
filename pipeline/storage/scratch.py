"""The scratch store: finished repeats and running checkpoints, outside DVC's sight.

DVC deletes a stage's outputs before it runs the stage, so a stage that is killed, or that has to
train one repeat more, would start from nothing. The scratch store keeps, per stage and repeat, a
folder keyed by a hash of everything that decides the result: inputs, parameters, code and repeat.
A finished repeat has a manifest of its files' hashes, to which it is held before it is used.
It can be deleted at any time; only time is lost.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from pipeline.contract.errors import BelvedereError

ENVIRONMENT_VARIABLE = "BELVEDERE_SCRATCH"


def root() -> Path:
    """The store's folder: ``$BELVEDERE_SCRATCH``, or ``.scratch`` in the working directory."""
    return Path(os.environ.get(ENVIRONMENT_VARIABLE) or ".scratch").resolve()


def digest_files(paths: Iterable[Path]) -> str:
    """A hash of files' contents and of their names within the given folders, wherever these lie."""
    hasher = hashlib.sha256()
    for path in paths:
        files = [path] if Path(path).is_file() else sorted(Path(path).rglob("*"))
        for file in files:
            if file.is_file():
                hasher.update(file.relative_to(path).as_posix().encode() + b"\0")
                hasher.update(file.read_bytes() + b"\0")
    return hasher.hexdigest()


def folder(stage: str, repeat: int, **cache_key: Any) -> Path:
    """The scratch folder of one repeat of a stage, made if need be.

    Args:
        stage: the stage's name.
        repeat: which repeat.
        **cache_key: JSON-able values that decide the result (hashes, parameters, versions).

    Raises:
        BelvedereError: the store cannot be written to.
    """
    key = json.dumps({"repeat": repeat, **cache_key}, sort_keys=True, default=str)
    path = root() / stage / hashlib.sha256(key.encode()).hexdigest()[:24]
    try:
        path.mkdir(parents=True, exist_ok=True)
        probe = path / f".write.{os.getpid()}"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise BelvedereError(
            f"the scratch store {path} cannot be written to ({error.strerror}); make it writable or "
            f"set {ENVIRONMENT_VARIABLE} to a folder that is."
        ) from None
    return path


@contextmanager
def locked(folders: Iterable[Path]) -> Iterator[None]:
    """Within it no other process is in any of these folders of the store; waits for its turn.

    Branches with the same viewpoint have the same keys, and ``./run --jobs`` makes them side by side.
    """
    with ExitStack() as stack:
        for place in sorted(folders):  # all take them in one order, so none waits for one that waits for it
            lock = stack.enter_context((place / ".lock").open("w"))
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                print(f"waiting for another process, which makes {place}")
                fcntl.flock(lock, fcntl.LOCK_EX)
        yield
