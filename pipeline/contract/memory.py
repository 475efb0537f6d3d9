"""What memory there is, held against what is known to be needed before a stage begins."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from pipeline.contract.errors import BelvedereError

_SYSTEM = Path("/")


@dataclass(frozen=True)
class _Files:
    """Where a version of Linux's control groups keeps what: ``given_back`` is an entry of memory.stat."""

    mount: str
    limit: str
    usage: str
    given_back: str


_VERSION_1 = _Files(
    "sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"
)
_VERSION_2 = _Files("sys/fs/cgroup", "memory.max", "memory.current", "inactive_file")


def available_bytes(system: Path = _SYSTEM) -> int | None:
    """What this process may still take: the least that the system and its control groups leave.

    Args:
        system: the folder in which ``proc`` and ``sys`` lie.

    Returns:
        Bytes; ``None`` where the system does not tell, as outside Linux.
    """
    found = [*_of_system(system), *_of_groups(system)]
    return max(0, min(found)) if found else None


def require(needed: int, what: str, remedy: Callable[[int], str], system: Path = _SYSTEM) -> None:
    """Refuses what needs more memory than there is.

    Args:
        needed: bytes.
        what: the parameter with its place and value.
        remedy: says, of the bytes that there are, what would fit.
        system: as in :func:`available_bytes`.

    Raises:
        BelvedereError: it needs more than there is.
    """
    there = available_bytes(system)
    if there is not None and needed > there:
        raise BelvedereError(
            f"{what} needs {_gib(needed)} of memory, of which {_gib(there)} are available here; "
            f"{remedy(there)}."
        )


def _gib(count: int) -> str:
    return f"{count / 2**30:,.2f} GiB"


def _of_system(system: Path) -> Iterator[int]:
    for line in _lines(system / "proc/meminfo"):
        name, _, value = line.partition(":")
        if name == "MemAvailable":
            yield int(value.split()[0]) * 1024


def _of_groups(system: Path) -> Iterator[int]:
    """What each control group leaves of its limit, from the process's own up to the root."""
    for line in _lines(system / "proc/self/cgroup"):
        _, controllers, path = line.split(":", 2)
        if controllers and "memory" not in controllers.split(","):
            continue
        files = _VERSION_1 if controllers else _VERSION_2
        top = system / files.mount
        own = top / path.lstrip("/")
        for folder in (own, *own.parents):
            yield from _left(folder, files)
            if folder == top:
                break


def _left(group: Path, files: _Files) -> Iterator[int]:
    limit, usage = (" ".join(_lines(group / name)) for name in (files.limit, files.usage))
    if not (limit.isdigit() and usage.isdigit()):  # "max", or no such group
        return
    stat = dict(line.split() for line in _lines(group / "memory.stat"))
    yield int(limit) - int(usage) + int(stat.get(files.given_back, 0))


def _lines(file: Path) -> list[str]:
    try:
        return file.read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
