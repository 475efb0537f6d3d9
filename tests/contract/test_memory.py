"""Memory that is known to be needed, held against what a system and its control groups leave."""

from __future__ import annotations

import sys
from pathlib import Path

import psutil
import pytest

from pipeline.contract.errors import BelvedereError
from pipeline.contract.memory import available_bytes, require

GIB = 2**30


def write(file: Path, text: str) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text)


def system(root: Path, groups: str, available_kib: int = 20 * 2**20) -> Path:
    write(root / "proc/meminfo", f"MemTotal: 99999999 kB\nMemFree: 1 kB\nMemAvailable: {available_kib} kB\n")
    write(root / "proc/self/cgroup", groups)
    return root


def version_2(folder: Path, limit: str, usage: int, cache: int = 0) -> None:
    write(folder / "memory.max", f"{limit}\n")
    write(folder / "memory.current", f"{usage}\n")
    write(folder / "memory.stat", f"anon 5\ninactive_file {cache}\n")


def version_1(folder: Path, limit: int, usage: int, cache: int = 0) -> None:
    write(folder / "memory.limit_in_bytes", f"{limit}\n")
    write(folder / "memory.usage_in_bytes", f"{usage}\n")
    write(folder / "memory.stat", f"inactive_file 1\ntotal_inactive_file {cache}\n")


@pytest.mark.skipif(sys.platform != "linux", reason="not run: no /proc")
def test_here_it_is_no_more_than_psutil_says() -> None:
    found = available_bytes()
    assert found is not None and 0 < found < 1.2 * psutil.virtual_memory().available


def test_without_limits_it_is_the_systems(tmp_path: Path) -> None:
    assert available_bytes(system(tmp_path, "0::/a\n")) == 20 * GIB
    version_2(tmp_path / "sys/fs/cgroup/a", "max", 3 * GIB)
    assert available_bytes(tmp_path) == 20 * GIB
    version_1(tmp_path / "sys/fs/cgroup/memory", 9223372036854771712, 3 * GIB)
    assert available_bytes(system(tmp_path, "4:memory:/\n")) == 20 * GIB


def test_every_group_above_counts_and_caches_can_be_given_back(tmp_path: Path) -> None:
    place = system(tmp_path, "0::/a/b\n") / "sys/fs/cgroup"
    version_2(place / "a/b", str(9 * GIB), 2 * GIB)
    assert available_bytes(tmp_path) == 7 * GIB
    version_2(place / "a", str(8 * GIB), 5 * GIB, cache=GIB)
    assert available_bytes(tmp_path) == 4 * GIB
    version_2(place / "a", str(8 * GIB), 9 * GIB)
    assert available_bytes(tmp_path) == 0


@pytest.mark.parametrize("path", ["/", "/docker/1234"])
def test_version_1_and_a_group_whose_path_is_not_seen_from_here(tmp_path: Path, path: str) -> None:
    """A container sees its own group as the root, whatever its path outside."""
    system(tmp_path, f"5:devices:{path}\n4:cpu,memory:{path}\n0::/\n")
    version_1(tmp_path / "sys/fs/cgroup/memory", 6 * GIB, 2 * GIB, cache=GIB)
    assert available_bytes(tmp_path) == 5 * GIB


def test_where_nothing_is_told_nothing_is_refused(tmp_path: Path) -> None:
    assert available_bytes(tmp_path) is None
    require(10**18, "it", lambda there: "less", tmp_path)


def test_what_does_not_fit_is_told_in_a_sentence(tmp_path: Path) -> None:
    system(tmp_path, "")
    require(20 * GIB, "a = 20", str, tmp_path)
    with pytest.raises(BelvedereError) as told:
        require(20 * GIB + 1, "a = 21", lambda there: f"at most {there // GIB} fit", tmp_path)
    assert str(told.value) == (
        "a = 21 needs 20.00 GiB of memory, of which 20.00 GiB are available here; at most 20 fit."
    )
