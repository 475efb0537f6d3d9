"""HTTP and the WebSocket: one page, its files, one connection."""

from __future__ import annotations

import asyncio
import socket
from pathlib import Path

from aiohttp import WSMsgType, web

from pipeline.contract.errors import BelvedereError
from pipeline.station.events import Answered
from pipeline.station.link import Link
from pipeline.station.messages import (
    MOST_BYTES,
    PROTOCOL,
    Answer,
    Hello,
    Malformed,
    checked_values,
    parsed,
)
from pipeline.station.rig import Rig
from pipeline.station.security import HOST, MESSAGES_A_SECOND, Gate, Rate

WEB = Path(__file__).with_name("web")
_KINDS = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
    ".json": "application/json",
}
_HELLO_WITHIN_S = 5.0
_HEARTBEAT_S = 10.0
_PROTOCOL_ERROR = 1008
_REQUEST_BYTES = 16 * 1024


class Server:
    """The station's face to the browser.

    Args:
        rig: is told what the page says.
        gate: who may come in.
        texts: texts.yaml as JSON.
    """

    def __init__(self, rig: Rig, gate: Gate, texts: str) -> None:
        self._rig, self._gate = rig, gate
        self._files = _files() | {"texts.json": ("application/json", texts.encode())}
        self._busy = False
        self.left = asyncio.Event()  # set whenever no page is connected
        self.left.set()
        self._runner: web.AppRunner | None = None

    async def start(self, listening: socket.socket) -> None:
        """Answers at a socket of the loopback address."""
        application = web.Application(middlewares=[self._gate.middleware], client_max_size=_REQUEST_BYTES)
        application.router.add_get("/", self._page)
        application.router.add_get("/ws", self._socket)
        application.router.add_get("/web/{name}", self._file)
        self._runner = web.AppRunner(application, access_log=None, handle_signals=False)
        await self._runner.setup()
        await web.SockSite(self._runner, listening).start()

    async def stop(self) -> None:
        """Closes the connection and listens no more."""
        if self._rig.link is not None:
            await self._rig.link.close(1001, "the station was ended")
        if self._runner is not None:
            await self._runner.cleanup()

    async def _page(self, request: web.Request) -> web.StreamResponse:
        if "token" in request.query:
            self._gate.enter(request.query["token"])
        return self._answer(request, "index.html")

    async def _file(self, request: web.Request) -> web.StreamResponse:
        return self._answer(request, request.match_info["name"])

    def _answer(self, request: web.Request, name: str) -> web.Response:
        """A file that was read at the start: a request's name is a key, and never a path."""
        self._gate.require_cookie(request)
        if name not in self._files:
            raise web.HTTPNotFound(text="There is no such file.\n")
        kind, content = self._files[name]
        return web.Response(body=content, content_type=kind, charset="utf-8")

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        self._gate.require_origin(request)
        self._gate.require_cookie(request)
        if self._busy:
            raise web.HTTPConflict(text="A page is connected already.\n")
        self._busy = True
        self.left.clear()
        try:
            return await self._converse(request)
        finally:
            self._busy = False
            self.left.set()

    async def _converse(self, request: web.Request) -> web.WebSocketResponse:
        page = web.WebSocketResponse(max_msg_size=MOST_BYTES, compress=False, heartbeat=_HEARTBEAT_S)
        await page.prepare(request)
        link = Link(page)
        sending = asyncio.create_task(link.run())
        try:
            await self._greet(page)
            self._rig.connect(link)
            await self._listen(page)
        except Malformed as error:
            print(f"the page was disconnected: {error}")
            await link.close(_PROTOCOL_ERROR, str(error))
        finally:
            sending.cancel()
            if self._rig.link is link:
                self._rig.disconnect()
        return page

    async def _greet(self, page: web.WebSocketResponse) -> None:
        try:
            message = await page.receive(timeout=_HELLO_WITHIN_S)
        except TimeoutError:
            raise Malformed("it said no hello") from None
        greeting = parsed(message.data) if message.type == WSMsgType.TEXT else None
        if not isinstance(greeting, Hello) or greeting.protocol != PROTOCOL:
            raise Malformed(f"the first message is no hello of protocol {PROTOCOL}")

    async def _listen(self, page: web.WebSocketResponse) -> None:
        rate = Rate(MESSAGES_A_SECOND)
        async for message in page:
            if message.type == WSMsgType.ERROR:
                return
            if message.type != WSMsgType.TEXT:
                raise Malformed("a message is no text")
            if not rate.allows():
                raise Malformed(f"more than {MESSAGES_A_SECOND} messages a second")
            self._hear(message.data)

    def _hear(self, text: str) -> None:
        message = parsed(text)
        if isinstance(message, Hello):
            raise Malformed("a second hello")
        if isinstance(message, Answer):
            self._rig.events.put_nowait(Answered(message.page, checked_values(message)))
        else:
            self._rig.heard(message)


def listening_socket(port: int) -> socket.socket:
    """A socket of the loopback address; port 0 takes a free one.

    Raises:
        BelvedereError: the port is taken.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((HOST, port))
        listening.listen()
    except OSError as error:
        listening.close()
        raise BelvedereError(
            f"port {port} of {HOST} cannot be listened at ({error.strerror}); name another: --port."
        ) from None
    return listening


def _files() -> dict[str, tuple[str, bytes]]:
    """Kind and content of the page's files, by name."""
    return {
        path.name: (_KINDS[path.suffix], path.read_bytes())
        for path in sorted(WEB.iterdir())
        if path.suffix in _KINDS and path.is_file()
    }
