"""The scripted operator as a client of the station: it comes by the link and drives in real time.

It stands where a browser and a person would, on the same WebSocket. Instead of looking at pictures it is
told places, which the station tells nobody else; it draws every picture all the same, so that latencies mean
the same.
"""

from __future__ import annotations

import contextlib
import io
import json
import time
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import urlsplit

import aiohttp
import numpy as np
from PIL import Image

from pipeline.scripted.law import ScriptedOperator
from pipeline.scripted.params import OperatorParams
from pipeline.sim.units import AXES
from pipeline.station.messages import PROTOCOL, picture_header
from pipeline.station.params import StationParams
from pipeline.station.sticks import pushes

_HEADER_BYTES = 16
_GAMEPAD = {
    "source": "gamepad",
    "device": "scripted operator",
    "mapping": "standard",
    "drift": 0.0,
    "window": [0, 0],
    "pixel_ratio": 1.0,
}


@dataclass
class Report:
    """What the operator met with.

    Attributes:
        pages: names, in order.
        latencies_ms: from an input to the drawn picture that first shows it.
        intervals_s: between pictures of the same attempt.
        size: width and height of the last picture.
        renderer: as the status has it.
        done: whether the session came to its end.
    """

    pages: list[str] = field(default_factory=list)
    latencies_ms: list[float] = field(default_factory=list)
    intervals_s: list[float] = field(default_factory=list)
    size: tuple[int, int] = (0, 0)
    renderer: str = ""
    done: bool = False


class Client:
    """One connection's conversation.

    Args:
        socket: the open WebSocket.
        operator, station: sections of params.yaml.
        rng: of the errors of looks.
        practise_s: how long it practises; None never stops.
        report: is filled in.
    """

    def __init__(
        self,
        socket: aiohttp.ClientWebSocketResponse,
        operator: OperatorParams,
        station: StationParams,
        rng: np.random.Generator,
        practise_s: float | None,
        report: Report,
    ) -> None:
        self.report = report
        self._socket, self._operator, self._station, self._rng = socket, operator, station, rng
        self._practise_s, self._practising_since = practise_s, 0.0
        self._law: ScriptedOperator | None = None
        self._axes: list[int] = []
        self._seq, self._seen, self._grasped = 0, 0, False
        self._sent_at: dict[int, float] = {}
        self._drawn_at: float | None = None

    async def run(self) -> None:
        """Until the session or the connection ends."""
        await self._say({"type": "hello", "protocol": PROTOCOL})
        async for message in self._socket:
            if message.type == aiohttp.WSMsgType.BINARY:
                await self._draw(message.data)
            elif message.type == aiohttp.WSMsgType.TEXT:
                await self._hear(json.loads(message.data))
            if self.report.done:
                break

    async def _say(self, message: dict[str, Any]) -> None:
        await self._socket.send_str(json.dumps(message))

    async def _draw(self, message: bytes) -> None:
        """Draws a picture and tells so."""
        frame, seq, _, _ = picture_header(message)
        picture = Image.open(io.BytesIO(message[_HEADER_BYTES:]))
        picture.load()
        now_s, latency_ms = time.monotonic(), None
        self.report.size = picture.size
        if seq > self._seen:
            self._seen = seq
            latency_ms = 1000 * (now_s - self._sent_at[seq])
            self.report.latencies_ms.append(latency_ms)
            self._sent_at = {number: at for number, at in self._sent_at.items() if number > seq}
        if self._drawn_at is not None:
            self.report.intervals_s.append(now_s - self._drawn_at)
        self._drawn_at = now_s
        await self._say({"type": "drawn", "frame": frame, "latency_ms": latency_ms})

    async def _hear(self, message: dict[str, Any]) -> None:
        if message["type"] == "status":
            self.report.renderer = message["renderer"]
        elif message["type"] == "places":
            await self._drive(message)
        elif message["type"] == "page":
            self._drawn_at = None
            self.report.pages.append(message["name"])
            await self._turn(message["name"], message["data"])

    async def _turn(self, page: str, data: dict[str, Any]) -> None:
        """Goes on from a page."""
        if page in ("trial", "practice"):
            self._axes = [AXES.index(axis) for axis in data["axes"]]
            frame_s = 1 / self._station.frames_per_second
            self._law = ScriptedOperator(self._operator, frame_s, 1, len(self._axes), self._rng)
            self._grasped = False
            await self._push(np.zeros(2), np.zeros(2))
        if page == "practice":
            await self._practise(data["elapsed_s"])
        elif page == "paused":
            await self._say({"type": "button", "name": "resume"})
        elif page in ("instructions", "ready", "feedback", "break"):
            await self._answer(page, {})
        elif page == "gamepad":
            await self._answer(page, _GAMEPAD)
        self.report.done = page in ("thanks", "error")

    async def _practise(self, elapsed_s: float) -> None:
        if self._practise_s is not None and elapsed_s >= self._practise_s:
            await self._answer("practice", {})

    async def _answer(self, page: str, values: dict[str, Any]) -> None:
        await self._say({"type": "answer", "page": page, "values": values})

    async def _drive(self, places: dict[str, Any]) -> None:
        """One control frame: looks, moves, and closes the gripper when it believes to be there."""
        if self._law is None or self._grasped:
            return
        tip, target, waypoint = (np.array(places[name]) for name in ("tip_m", "target_m", "waypoint_m"))
        act = self._law.act((waypoint - tip)[None, self._axes], (target - tip)[None, self._axes])
        wide = np.zeros(3)
        wide[self._axes] = act.velocity_m_s[0] / self._station.speed_m_s
        await self._push(*pushes(np.array(places["sticks_to_world"]), wide, self._station.dead_zone))
        if act.grasps[0]:
            self._grasped = True
            await self._say({"type": "button", "name": "a"})

    async def _push(self, left: np.ndarray, right: np.ndarray) -> None:
        self._seq += 1
        self._sent_at[self._seq] = time.monotonic()
        sticks = {"left": np.clip(left, -1, 1).tolist(), "right": np.clip(right, -1, 1).tolist()}
        source = {"source": "gamepad", "device": _GAMEPAD["device"]}
        await self._say({"type": "input", "seq": self._seq, **sticks, **source})


async def operate(
    link: str,
    operator: OperatorParams,
    station: StationParams,
    rng: np.random.Generator,
    practise_s: float | None = 0.0,
    report: Report | None = None,
) -> Report:
    """Comes by a link and goes through the session.

    Args:
        link: as the station prints it.
        operator, station: sections of params.yaml.
        rng: of the errors of looks.
        practise_s: how long it practises at least; None never stops.
        report: is filled in as it goes, for one who does not wait for the end.

    Returns:
        What it met with, also where the station ended before the session.
    """
    at, report = urlsplit(link), Report() if report is None else report
    origin, address = f"{at.scheme}://{at.netloc}", f"ws://{at.netloc}/ws"
    ended = contextlib.suppress(aiohttp.ClientError, ConnectionError)
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
        with ended:
            async with session.get(link) as answer:
                answer.raise_for_status()
            async with session.ws_connect(address, headers={"Origin": origin}, max_msg_size=0) as socket:
                await Client(socket, operator, station, rng, practise_s, report).run()
    return report
