"""Progress: a bar on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Any

from tqdm import tqdm

LINE_EVERY_S = 20.0


class Progress:
    """A progress bar that falls back to lines where there is no terminal.

    Use as a context manager; call :meth:`advance` after each step.
    """

    def __init__(self, total: int, what: str, initial: int = 0) -> None:
        self._bar = tqdm(total=total, desc=what, initial=initial, disable=None, leave=False)
        self._what, self._total, self._done = what, total, initial
        self._said = time.monotonic()

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.close()

    def advance(self, steps: int = 1, **facts: Any) -> None:
        """Counts ``steps`` more; ``facts`` are shown behind the bar."""
        self._done += steps
        if facts:
            self._bar.set_postfix(facts, refresh=False)
        self._bar.update(steps)
        if self._bar.disable and time.monotonic() - self._said > LINE_EVERY_S:
            self._said = time.monotonic()
            shown = " ".join(f"{k}={v}" for k, v in facts.items())
            print(f"{self._what}: {self._done}/{self._total} {shown}".rstrip(), file=sys.stderr)
