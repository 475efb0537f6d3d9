"""DVC's list of what is being read and written, kept usable after a kill.

DVC empties `.dvc/tmp/rwlock` and writes it again, so a process that is killed in between leaves no JSON, with
which every later run would end ("JSON structure is corrupted").
"""

from __future__ import annotations

import json
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any


def drop_damaged_rwlock() -> None:
    """Makes DVC, in this process, begin a new list where a killed process left half of one."""
    from dvc import rwlock

    plain = rwlock._edit_rwlock

    def edit(lock_dir: str, fs: Any, hardlink: bool) -> AbstractContextManager[Any]:
        _drop_damaged(Path(lock_dir), hardlink)
        return plain(lock_dir, fs, hardlink)

    rwlock._edit_rwlock = edit


def _drop_damaged(folder: Path, hardlink: bool) -> None:
    from dvc.lock import make_lock
    from dvc.rwlock import RWLOCK_FILE, RWLOCK_LOCK

    path = folder / RWLOCK_FILE
    if not path.is_file() or _is_json(path):
        return
    with make_lock(str(folder / RWLOCK_LOCK), tmp_dir=str(folder), hardlink_lock=hardlink):
        if path.is_file() and not _is_json(path):  # while we hold this lock nobody is writing it
            path.unlink()


def _is_json(path: Path) -> bool:
    try:
        json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        return False
    return True
