"""The one connection to the page: what is said goes out by it, or nowhere."""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from collections import deque
from typing import Any

import numpy as np
from aiohttp import web

from pipeline.station.feed import Feed

_RECENT_S = 5.0


class Latencies:
    """How long inputs took to be seen, in milliseconds, as the page measures it."""

    def __init__(self) -> None:
        self._of_attempt: list[float] = []
        self._recent: deque[tuple[float, float]] = deque()

    def add(self, milliseconds: float) -> None:
        """One more."""
        self._of_attempt.append(milliseconds)
        self._recent.append((time.monotonic(), milliseconds))

    def clear(self) -> None:
        """A new attempt begins."""
        self._of_attempt.clear()

    def of_attempt(self) -> tuple[float | None, float | None]:
        """Median and 95th percentile since the attempt began; None where none was measured."""
        return quantiles(self._of_attempt)

    def recent(self) -> tuple[float | None, float | None]:
        """The same over the last seconds."""
        while self._recent and self._recent[0][0] < time.monotonic() - _RECENT_S:
            self._recent.popleft()
        return quantiles([value for _, value in self._recent])


def quantiles(values: list[float]) -> tuple[float | None, float | None]:
    """Median and 95th percentile, to a tenth; None of nothing."""
    if not values:
        return None, None
    middle, high = np.percentile(values, [50, 95])
    return round(float(middle), 1), round(float(high), 1)


class Link:
    """A page that is there.

    Args:
        socket: its WebSocket.
    """

    def __init__(self, socket: web.WebSocketResponse) -> None:
        self.feed = Feed(socket.send_bytes, self.say)
        self._socket = socket
        self._outgoing: asyncio.Queue[str] = asyncio.Queue()

    def say(self, message: dict[str, Any]) -> None:
        """Sends a message as soon as may be, in order."""
        self._outgoing.put_nowait(json.dumps(message, ensure_ascii=False, allow_nan=False))

    async def run(self) -> None:
        """Sends until the page is gone."""
        with contextlib.suppress(ConnectionError):
            await asyncio.gather(self._say_all(), self.feed.run())

    async def _say_all(self) -> None:
        while True:
            await self._socket.send_str(await self._outgoing.get())

    async def close(self, code: int, reason: str) -> None:
        """Ends the connection."""
        await self._socket.close(code=code, message=reason.encode()[:120])
