"""Pictures on their way: at most two on the road, the newest first, nothing queued."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from pipeline.station.feed import MOST_WAITING, Feed


class Page:
    """Receives pictures; acknowledges when it is told to."""

    def __init__(self) -> None:
        self.received: list[bytes] = []
        self.said: list[dict[str, Any]] = []
        self.feed = Feed(self._send, self.said.append)

    async def _send(self, message: bytes) -> None:
        await asyncio.sleep(0)
        self.received.append(message)

    async def offer(self, *frames: int) -> None:
        for frame in frames:
            self.feed.offer(frame, bytes([frame]))
            await settle()


async def settle() -> None:
    for _ in range(10):
        await asyncio.sleep(0)


def driven(script: Callable[[Page], Any]) -> Page:
    async def run() -> Page:
        page = Page()
        sending = asyncio.create_task(page.feed.run())
        await script(page)
        sending.cancel()
        return page

    return asyncio.run(run())


def test_a_page_that_keeps_up_gets_everything() -> None:
    async def script(page: Page) -> None:
        for frame in range(1, 20):
            await page.offer(frame)
            page.feed.acknowledge(frame)

    page = driven(script)
    assert [m[0] for m in page.received] == list(range(1, 20))
    assert page.feed.sent == 19 and page.feed.dropped == 0


def test_a_page_that_acknowledges_nothing_gets_two_and_no_queue_forms() -> None:
    async def script(page: Page) -> None:
        await page.offer(*range(1, 100))
        assert len(page.received) == MOST_WAITING
        page.feed.acknowledge(1)
        await settle()

    page = driven(script)
    assert [m[0] for m in page.received] == [1, 2, 99]  # what waited was overtaken
    assert page.feed.dropped == 96


def test_an_acknowledgement_covers_all_before_it() -> None:
    async def script(page: Page) -> None:
        await page.offer(1, 2, 3)
        page.feed.acknowledge(2)
        await settle()
        await page.offer(4)

    assert [m[0] for m in driven(script).received] == [1, 2, 3, 4]


def test_sent_and_dropped_are_all_that_was_offered_but_what_waits() -> None:
    async def script(page: Page) -> None:
        await page.offer(*range(1, 50))
        page.feed.acknowledge(2)
        await settle()
        await page.offer(*range(50, 90))

    page = driven(script)
    assert page.feed.sent + page.feed.dropped in (88, 89)


def test_what_belongs_beside_a_picture_is_said_of_sent_ones_only() -> None:
    async def script(page: Page) -> None:
        for frame in range(1, 6):
            page.feed.offer(frame, bytes([frame]), {"frame": frame})
            await settle()

    page = driven(script)
    assert [said["frame"] for said in page.said] == [1, 2]
