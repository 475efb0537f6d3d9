"""What runs beside the session's course: physics, pictures, the page's connection; and what they report."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from pipeline.contract.machine import cores
from pipeline.contract.viewpoints import Viewpoint
from pipeline.sim.scene import Scene
from pipeline.station.attempt import Attempt
from pipeline.station.events import Began, Ended, Event, Gone, Pressed
from pipeline.station.feed import Feed
from pipeline.station.inputs import Mailbox, Push
from pipeline.station.link import Latencies, Link
from pipeline.station.messages import Button, Drawn, Input, picture_message
from pipeline.station.painter import Painter
from pipeline.station.physics import Physics, Snapshot
from pipeline.station.pictures import Choice
from pipeline.station.sticks import Sticks

LATE_MS, SLOW = 100.0, 0.98  # beyond these a trial is flagged


class Rig:
    """Threads and connection of a running station.

    Args:
        frame_s: length of a control frame.
        tells: whether places are told beside pictures, which only the scripted operator may know.
    """

    def __init__(self, frame_s: float, tells: bool) -> None:
        self.events: asyncio.Queue[Event] = asyncio.Queue()
        self.link: Link | None = None
        self.latencies = Latencies()
        self.choice: Choice | None = None
        self._loop = asyncio.get_running_loop()
        self._tells, self._sticks = tells, np.eye(3)
        self._page: dict[str, Any] | None = None
        self._feed: Feed | None = None
        self._sent_before = 0
        self._attempt: Attempt | None = None
        self._mailbox = Mailbox()
        self.painter = Painter(min(cores(), 4), lambda *of: self._later(self._painted, *of))
        self.physics = Physics(
            self._mailbox,
            frame_s,
            self.painter.show,
            lambda attempt: self._later(self.events.put_nowait, Began(attempt)),
            lambda attempt: self._later(self.events.put_nowait, Ended(attempt)),
        )

    def _later(self, work: Any, *arguments: object) -> None:
        self._loop.call_soon_threadsafe(work, *arguments)

    def start(self) -> None:
        """Starts the threads."""
        self.painter.start()
        self.physics.start()

    def stop(self) -> None:
        """Ends the threads."""
        self.physics.stop()
        self.painter.stop()
        self.physics.join()
        self.painter.join()

    def failure(self) -> BaseException | None:
        """What ended a thread, if something did."""
        return self.physics.failure or self.painter.failure

    def show(self, name: str, data: Mapping[str, Any]) -> None:
        """Shows a page: now, and to one that comes back later."""
        self._page = {"type": "page", "name": name, "data": dict(data)}
        if self.link is not None:
            self.link.say(self._page)

    def connect(self, link: Link) -> None:
        """The page is there; it is shown what is on."""
        self.link = link
        if self._page is not None:
            link.say(self._page)

    def disconnect(self) -> None:
        """The page is gone."""
        self.link = None
        self._mailbox.clear()
        self.events.put_nowait(Gone())

    async def begin(self, attempt: Attempt, sticks: Sticks, scene: Scene, name: str, view: Viewpoint) -> None:
        """Shows the scene from a view, and lets the hands move it."""
        assert self.choice is not None
        await asyncio.wrap_future(self.painter.turn_to(self.choice, scene, name, view))
        self._sticks = sticks.to_world
        self.latencies.clear()
        self._feed = self.link.feed if self.link else None
        self._sent_before = self._feed.sent if self._feed else 0
        self._attempt = attempt
        self.physics.begin(attempt)

    def rest(self) -> None:
        """Nothing is shown or moved any more; an attempt that had begun is broken off."""
        self.physics.rest()
        self._attempt = None

    def sent(self) -> int:
        """Pictures sent since :meth:`begin`."""
        return self._feed.sent - self._sent_before if self._feed else 0

    def heard(self, message: Input | Button | Drawn) -> None:
        """The page says what the hands do, or what it has drawn."""
        now_s = time.monotonic()
        if isinstance(message, Input):
            left, right = np.array(message.left), np.array(message.right)
            self._mailbox.push(Push(message.seq, now_s, left, right, message.source, message.device))
        elif isinstance(message, Drawn):
            if self.link is not None:
                self.link.feed.acknowledge(message.frame)
            if message.latency_ms is not None and self._attempt is not None:
                self.latencies.add(message.latency_ms)
        elif message.name in ("pause", "resume"):
            self.events.put_nowait(Pressed(message.name))
        else:
            self._mailbox.button(message.name, now_s)

    def _painted(self, snapshot: Snapshot, jpeg: bytes) -> None:
        if self.link is None or self._attempt is None:
            return
        picture = picture_message(snapshot.frame, snapshot.seq, snapshot.simulated_ms, jpeg)
        self.link.feed.offer(snapshot.frame, picture, self._told(snapshot) if self._tells else None)

    def _told(self, snapshot: Snapshot) -> dict[str, Any]:
        """What the scripted operator sees: places in metres, and where sticks lead."""
        return {
            "type": "places",
            "frame": snapshot.frame,
            "tip_m": snapshot.tip_m.tolist(),
            "target_m": snapshot.target_m.tolist(),
            "waypoint_m": snapshot.waypoint_m.tolist(),
            "sticks_to_world": self._sticks.tolist(),
        }

    async def tell_status(self) -> None:
        """Tells the experimenter's bar once a second how it goes.

        Raises:
            BaseException: whatever ended a thread.
        """
        sent, frame, begin_s = 0, 0, time.monotonic()
        attempt = self._attempt
        while True:
            await asyncio.sleep(1.0)
            failure = self.failure()
            if failure is not None:
                raise failure
            if self.link is None or self.choice is None:
                continue
            now_s, feed = time.monotonic(), self.link.feed
            frames = self.physics.frames
            steady = self._attempt is not None and self._attempt is attempt
            attempt = self._attempt
            rate, sent = max(feed.sent - sent, 0) / (now_s - begin_s), feed.sent
            factor = (frames - frame) * self.physics.frame_s / (now_s - begin_s) if steady else None
            frame, begin_s = frames, now_s
            middle, high = self.latencies.recent()
            self.link.say(
                {
                    "type": "status",
                    "renderer": self.choice.name,
                    "picture": list(self.choice.size),
                    "fps": round(rate, 1),
                    "latency_ms_p50": middle,
                    "latency_ms_p95": high,
                    "real_time_factor": None if factor is None else round(factor, 3),
                    "flags": flags(high, factor),
                }
            )


def flags(latency_ms_p95: float | None, real_time_factor: float | None) -> list[str]:
    """Which limits were not kept."""
    late = latency_ms_p95 is not None and latency_ms_p95 > LATE_MS
    slow = real_time_factor is not None and real_time_factor < SLOW
    return ["latency"] * late + ["real_time"] * slow
