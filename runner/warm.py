"""Stages without their start: a process that has imported what stages import, and forks one for each of them.

A branch's stages run one after the other in one process of DVC's. Each would import PyTorch, Zarr, Polars and
MuJoCo Warp again, which takes seconds a stage. Nothing of the project is imported here: a stage's own code is
read when the stage begins, as by `python -m`.
"""

from __future__ import annotations

import ctypes
import gc
import importlib
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Mapping, Sequence
from typing import Any, NoReturn

# Of a branch; the stages of scenes run alone in their processes, and import less.
STAGES = ("frames", "geometry", "operator", "vae", "latents", "mdnrnn", "controller", "evaluation", "dqn")
LIBRARIES = ("numpy", "torch", "zarr", "polars", "mujoco_warp", "cma", "PIL.Image")
_PR_SET_PDEATHSIG = 1


class Warm:
    """Runs stages in forks of one process; begins it at the first."""

    def __init__(self) -> None:
        self._socket: socket.socket | None = None

    def run(self, module: str, arguments: Sequence[str], cwd: str, environment: Mapping[str, str]) -> int:
        """What ``python -m module …`` ends with: its exit status, or minus the signal that ended it."""
        if self._socket is None:
            self._socket = _begin()
        asked = {"module": module, "arguments": arguments, "cwd": cwd, "environment": dict(environment)}
        try:
            with self._socket.makefile("rw", encoding="utf-8") as lines:
                lines.write(json.dumps(asked) + "\n")
                lines.flush()
                answer = lines.readline()
        except ConnectionError:
            answer = ""
        return int(answer) if answer else -signal.SIGKILL  # the process is gone


def _begin() -> socket.socket:
    ours, theirs = socket.socketpair()
    command = [sys.executable, "-m", "runner.warm", str(theirs.fileno()), str(os.getpid())]
    subprocess.Popen(command, pass_fds=[theirs.fileno()])
    theirs.close()
    return ours


def serve(descriptor: int, parent: int) -> None:
    """Waits for stages until the other end is closed or the parent has ended."""
    _die_with(parent)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is the stage's to handle
    for name in LIBRARIES:
        importlib.import_module(name)
    gc.freeze()  # so that no stage walks through the libraries' objects
    with socket.socket(fileno=descriptor) as end, end.makefile("rw", encoding="utf-8") as lines:
        while asked := lines.readline():
            own, child = os.getpid(), os.fork()
            if not child:
                _die_with(own)
                end.close()
                _be_stage(**json.loads(asked))
            lines.write(f"{os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])}\n")
            lines.flush()


def _be_stage(module: str, arguments: Sequence[str], cwd: str, environment: dict[str, str]) -> NoReturn:
    """Becomes the stage: never returns to what the parent was doing."""
    status: Any = 1
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        os.chdir(cwd)
        os.environ.clear()
        os.environ.update(environment)
        sys.argv = [module, *arguments]
        runpy.run_module(module, run_name="__main__", alter_sys=True)
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
        if end.code is not None and not isinstance(end.code, int):
            print(end.code, file=sys.stderr)
    except BaseException:  # as Python does with what nobody catches
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status or 0)


def _die_with(parent: int) -> None:
    if sys.platform == "linux":
        ctypes.CDLL(None, use_errno=True).prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:  # it ended before we asked
            os._exit(1)


if __name__ == "__main__":
    serve(*map(int, sys.argv[1:]))
