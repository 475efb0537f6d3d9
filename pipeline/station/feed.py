"""Pictures on their way to the page: at most two unacknowledged, never one that has been overtaken."""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any

MOST_WAITING = 2
_SILENT_S = 2.0  # a page that acknowledges nothing for so long is sent a picture all the same


class Feed:
    """Sends the newest picture as soon as the page has drawn what it was sent.

    Args:
        send: sends a picture.
        say: sends what belongs beside it.
    """

    def __init__(
        self, send: Callable[[bytes], Awaitable[None]], say: Callable[[dict[str, Any]], None]
    ) -> None:
        self.sent, self.dropped = 0, 0
        self._send, self._say = send, say
        self._unacknowledged: deque[tuple[int, float]] = deque()
        self._newest: tuple[int, bytes, dict[str, Any] | None] | None = None
        self._wake = asyncio.Event()

    def offer(self, frame: int, message: bytes, beside: dict[str, Any] | None = None) -> None:
        """A new picture; one that still waits is dropped.

        Args:
            frame: its number.
            message: the picture.
            beside: a message to follow it.
        """
        self.dropped += self._newest is not None
        self._newest = frame, message, beside
        self._wake.set()

    def acknowledge(self, frame: int) -> None:
        """The page has drawn this picture, and so needs none before it."""
        while self._unacknowledged and self._unacknowledged[0][0] <= frame:
            self._unacknowledged.popleft()
        self._wake.set()

    async def run(self) -> None:
        """Sends until it is cancelled."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            if self._newest is None or not self._may_send():
                continue
            frame, message, beside = self._newest
            self._newest = None
            self._unacknowledged.append((frame, time.monotonic()))
            self.sent += 1
            await self._send(message)
            if beside is not None:
                self._say(beside)
            self._wake.set()

    def _may_send(self) -> bool:
        waiting = self._unacknowledged
        if len(waiting) >= MOST_WAITING and time.monotonic() - waiting[-1][1] > _SILENT_S:
            waiting.clear()
        return len(waiting) < MOST_WAITING
