"""Disks that are full or read-only: knowing them from what libraries raise, and what to say."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from pathlib import Path

from pipeline.storage import scratch

_BY_NUMBER = (errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
# shutil.copytree, Polars and others raise errors of their own, without a number, around the system's words
_BY_WORDS = (errno.EROFS, errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
_LITTLE_BYTES = 64 * 2**20
CACHES = ("WARP_CACHE_PATH", "MPLCONFIGDIR", "XDG_CACHE_HOME", "TMPDIR", scratch.ENVIRONMENT_VARIABLE)


def unwritable(error: Exception) -> str | None:
    """The system's words where ``error`` says that a file cannot be written, else None."""
    number = getattr(error, "errno", None)
    if isinstance(error, OSError) and number in _BY_NUMBER:
        return os.strerror(number)
    said = str(error)
    return next((os.strerror(n) for n in _BY_WORDS if os.strerror(n) in said), None)


def cache_sentence(error: Exception, reason: str) -> str:
    """What to say of an error outside any output: it befell a cache or a temporary file.

    Args:
        error: what was raised.
        reason: what :func:`unwritable` said of it.
    """
    named = getattr(error, "filename", None)
    what = str(named) if named else "a cache or temporary file"
    full = ", ".join(str(place) for place in _places() if _has_little_space(place))
    where = f"; little space is left in {full}" if full else ""
    return (
        f"{what} cannot be read or written ({reason}){where}; make room or give permission there, or set "
        f"{', '.join(CACHES[:-1])} or {CACHES[-1]} to a writable folder with space."
    )


def _places() -> list[Path]:
    """The folders in which this process keeps files that are no outputs."""
    chosen = [Path(os.environ[name]) for name in CACHES if os.environ.get(name)]
    places = [*chosen, Path.home(), Path(tempfile.gettempdir()), scratch.root().parent]
    return list(dict.fromkeys(place for place in places if place.is_dir()))


def _has_little_space(place: Path) -> bool:
    return shutil.disk_usage(place).free < _LITTLE_BYTES
