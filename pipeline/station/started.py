"""A station in a process of its own, and its link: for demonstrations, benchmarks and tests."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from pipeline.contract.errors import BelvedereError
from pipeline.contract.source import ROOT

_ENDS_WITHIN_S = 20.0


class Started:
    """A running station; leaving the context ends it.

    Args:
        arguments: of the command line, such as ``["--port", "0"]``.
        folder: the working directory, which holds params.yaml.
        quiet: whether what it prints is kept back.

    Raises:
        BelvedereError: it ended before it printed a link; holds what it said.
    """

    def __init__(self, arguments: Sequence[str], folder: Path = Path(), quiet: bool = False) -> None:
        self.lines: list[str] = []
        self.process = subprocess.Popen(
            [sys.executable, "-m", "pipeline.station", *arguments],
            cwd=folder,
            env=_environment(),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self._quiet, self._told = quiet, threading.Event()
        threading.Thread(target=self._listen, name="station's words", daemon=True).start()
        self._told.wait()
        self.link = next((line for line in self.lines if line.startswith("http://")), "")
        if not self.link:
            raise BelvedereError(
                f"the station did not start: {' '.join(self.lines[-3:]) or 'it said nothing'}"
            )

    def _listen(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            self.lines.append(line.strip())
            if not self._quiet:
                print(line, end="")
            if self.lines[-1].startswith("http://"):
                self._told.set()
        self._told.set()

    def __enter__(self) -> Started:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.end()

    def end(self) -> int:
        """Ends it, if it still runs; returns its exit status."""
        if self.process.poll() is None:
            self.process.terminate()
        return self.wait()

    def wait(self) -> int:
        """Waits for its end, in the end without mercy; returns its exit status."""
        try:
            return self.process.wait(_ENDS_WITHIN_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            return self.process.wait()


def _environment() -> dict[str, str]:
    return {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": "1"}
