"""A stage ends with the DVC that started it: an orphan could write over a later run's output.

It is the first that a stage imports, so that it watches before libraries are loaded, which takes seconds.
"""

from __future__ import annotations

import ctypes
import os
import select
import signal
import sys
import threading
from pathlib import Path

STAGE_VARIABLE = "DVC_STAGE"  # DVC sets it for a stage's command
# DVC runs a command in a shell, some of which stay between it and the stage.
_SHELLS = {"sh", "dash", "bash", "zsh", "ksh", "mksh", "fish", "busybox"}
_PR_SET_PDEATHSIG = 1


def end_with_dvc() -> None:
    """Ends this process when DVC, or a shell between the two, ends; at once if DVC is gone already.

    Outside a stage, and on other systems, nothing is done.
    """
    if sys.platform != "linux" or STAGE_VARIABLE not in os.environ:
        return
    parent = os.getppid()
    starter = _without_shells(parent)
    ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
    if starter is None or os.getppid() != parent:
        _end()
    if starter != parent:
        threading.Thread(target=_wait_for, args=(starter,), name="wait for DVC", daemon=True).start()


def _without_shells(pid: int) -> int | None:
    """The nearest of the process and its ancestors that is no shell; None where that did not start us.

    An orphan's parent is one that adopts orphans: the first process, or one of another session.
    """
    while pid > 0 and _name(pid) in _SHELLS:
        pid = _parent(pid)
    try:
        adopted = os.getsid(pid) != os.getsid(0) or (pid == 1 and "dvc" not in _command(pid))
    except ProcessLookupError:
        return None
    return None if pid <= 0 or adopted else pid


def _wait_for(pid: int) -> None:
    try:
        descriptor = os.pidfd_open(pid)
    except ProcessLookupError:
        _end()
    poll = select.poll()
    poll.register(descriptor, select.POLLIN)
    poll.poll()
    _end()


def _end() -> None:
    os.kill(os.getpid(), signal.SIGTERM)


def _name(pid: int) -> str:
    return _read(pid, "comm").strip()


def _command(pid: int) -> str:
    return _read(pid, "cmdline").replace("\0", " ")


def _parent(pid: int) -> int:
    """The parent's number; 0 where the process is gone or has none."""
    after_name = _read(pid, "stat").rpartition(")")[2].split()
    return int(after_name[1]) if after_name else 0


def _read(pid: int, name: str) -> str:
    try:
        return Path(f"/proc/{pid}/{name}").read_text(encoding="utf-8", errors="replace")
    except OSError:
        return ""
