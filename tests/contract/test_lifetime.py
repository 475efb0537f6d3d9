"""A stage that DVC started ends with it, however it was started."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.support import ROOT

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="not run: Linux only")

WORK = (
    "import pathlib, time; pathlib.Path('started').touch(); time.sleep(60); pathlib.Path('survived').touch()"
)
STAGE = f"import pipeline; {WORK}"
# Its parent ends before it has come to import anything of the pipeline.
LATE = (
    "import os, pathlib, time; parent = os.getppid(); pathlib.Path('begun').touch()\n"
    "while os.getppid() == parent: time.sleep(0.02)\n" + STAGE
)
POOL = """
from pipeline.learning.side_by_side import in_processes
from tests.contract.test_lifetime import busy
if __name__ == "__main__":
    in_processes(busy, 2)
"""
DVC = """
import os, subprocess, sys
os.environ["DVC_STAGE"] = "vae"
process = subprocess.Popen(sys.argv[1:])
print(process.pid, flush=True)
process.wait()
"""


Start = Callable[..., tuple[subprocess.Popen[str], int]]


def busy(number: int) -> None:
    """What a process of a pool does."""
    Path(f"pid-{number}").write_text(str(os.getpid()), encoding="utf-8")
    time.sleep(60)


@pytest.fixture
def dvc(tmp_path: Path) -> Start:
    """Starts a command as DVC does; gives DVC, and the number of the process that it started."""

    def start(*command: str) -> tuple[subprocess.Popen[str], int]:
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "BELVEDERE_CORES": "2"}
        started = subprocess.Popen(
            [sys.executable, "-c", DVC, *command],
            cwd=tmp_path,
            stdout=subprocess.PIPE,
            text=True,
            env=environment,
        )
        assert started.stdout is not None
        return started, int(started.stdout.readline())

    return start


@pytest.mark.parametrize("how", ["direct", "below a shell"])
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_a_stage_ends_with_its_dvc(dvc: Start, tmp_path: Path, how: str, number: int) -> None:
    stage = [sys.executable, "-c", STAGE]
    # a shell with something left to do stays between DVC and the stage, as dash does
    command = stage if how == "direct" else ["/bin/sh", "-c", '"$@"; true', "sh", *stage]
    parent, pid = dvc(*command)
    wait_until((tmp_path / "started").exists)
    stages = [pid] if how == "direct" else children(pid)
    assert len(stages) == 1 and running(stages[0])
    parent.send_signal(number)
    wait_until(lambda: not running(stages[0]))
    parent.wait()


def test_a_stage_whose_dvc_is_gone_does_nothing(dvc: Start, tmp_path: Path) -> None:
    parent, pid = dvc(sys.executable, "-c", LATE)
    wait_until((tmp_path / "begun").exists)
    parent.kill()
    parent.wait()
    wait_until(lambda: not running(pid))
    assert not (tmp_path / "started").exists()


def test_the_processes_of_a_pool_end_with_the_stage(dvc: Start, tmp_path: Path) -> None:
    (tmp_path / "pool.py").write_text(POOL, encoding="utf-8")
    parent, _ = dvc(sys.executable, "pool.py")
    wait_until(lambda: all((tmp_path / f"pid-{n}").exists() for n in range(2)))
    pids = [int((tmp_path / f"pid-{n}").read_text(encoding="utf-8")) for n in range(2)]
    parent.kill()
    parent.wait()
    wait_until(lambda: not any(running(pid) for pid in pids))


def children(pid: int) -> list[int]:
    return [
        int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="utf-8").split()
    ]


def wait_until(holds: Callable[[], bool], within_s: float = 20.0) -> None:
    end = time.monotonic() + within_s
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def running(pid: int) -> bool:
    """Whether a process still runs; one that has ended and is not yet reaped does not."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False
