"""What the tests of the page share: a gamepad in the browser, a watched page, a station told what to say."""

from __future__ import annotations

import asyncio
import io
import json
import struct
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from aiohttp import WSMsgType, web
from PIL import Image
from playwright.sync_api import Browser, Page, sync_playwright

from pipeline.station.texts import read_texts

WEB = Path(__file__).resolve().parents[2] / "pipeline/station/web"
CSP = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
    ".json": "application/json",
}
PATIENCE_S = 20.0

# An Xbox-like gamepad that a test moves: `pad.axes`, `pad.buttons`; none while `pad` is null.
GAMEPAD = """
window.makePad = (mapping = "standard") => ({
  id: "Test Gamepad (Vendor: 046d Product: c21d)", index: 0, connected: true, mapping, axes: [0, 0, 0, 0],
  buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0})), timestamp: 0,
});
window.pad = null;
navigator.getGamepads = () => [window.pad, null, null, null];
"""


@contextmanager
def chromium_browser(executable: str) -> Iterator[Browser]:
    """Headless Chromium; no sandbox: root, as in a container, may have none. The page is our own."""
    with sync_playwright() as playwright:
        opened = playwright.chromium.launch(executable_path=executable, args=["--no-sandbox"])
        yield opened
        opened.close()


class Watched:
    """A page with an injected gamepad, and what it asked for and complained of."""

    def __init__(self, browser: Browser, scheme: str = "light", width: int = 1280, height: int = 900) -> None:
        self.context = browser.new_context(color_scheme=scheme, viewport={"width": width, "height": height})
        self.context.add_init_script(GAMEPAD)
        self.page: Page = self.context.new_page()
        self.requests: list[str] = []
        self.complaints: list[str] = []
        self.page.on("request", lambda asked: self.requests.append(asked.url))
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))

    def shown(self, name: str) -> None:
        """Waits until the page of that name is shown."""
        self.page.wait_for_selector(f"body[data-page='{name}']", timeout=PATIENCE_S * 1000)

    def connect_pad(self, mapping: str = "standard") -> None:
        self.page.evaluate("mapping => { window.pad = makePad(mapping); }", mapping)

    def sticks(self, left: tuple[float, float] = (0, 0), right: tuple[float, float] = (0, 0)) -> None:
        self.page.evaluate("axes => { pad.axes = axes; }", [*left, *right])

    def press(self, button: int) -> None:
        """Presses a button of the gamepad for two animation frames."""
        self.page.evaluate(
            """async at => {
              const frame = () => new Promise(requestAnimationFrame);
              pad.buttons[at] = {pressed: true, touched: true, value: 1};
              await frame(); await frame();
              pad.buttons[at] = {pressed: false, touched: false, value: 0};
              await frame(); await frame();
            }""",
            button,
        )

    def wait(self, seconds: float) -> None:
        self.page.wait_for_timeout(seconds * 1000)


def picture(frame: int, seq: int = 0, size: tuple[int, int] = (640, 480), grey: int = 90) -> bytes:
    """A binary message with a JPEG of one grey and a header as the protocol has it."""
    pixels = np.full((size[1], size[0], 3), grey, np.uint8)
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG")
    return struct.pack("<4I", frame, seq, 40 * frame, 1) + file.getvalue()


class ToldStation:
    """A station that sends what a test tells it to, and keeps what the page sends; without any robot."""

    def __init__(self) -> None:
        self.received: list[dict[str, Any]] = []
        self.refuse = False
        self.sockets: list[web.WebSocketResponse] = []
        self.loop = asyncio.new_event_loop()
        self.port = 0
        started = threading.Event()
        self.thread = threading.Thread(target=self._run, args=(started,), daemon=True)
        self.thread.start()
        started.wait(PATIENCE_S)

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}/"

    def send(self, message: dict[str, Any] | bytes) -> None:
        self._do(self._send(message))

    def show(self, name: str, **data: Any) -> None:
        self.send({"type": "page", "name": name, "data": data})

    def end(self, code: int) -> None:
        """Closes the open socket with a code."""
        self._do(self.sockets[-1].close(code=code))

    def wait_for(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The first message received that is wanted."""
        until = time.monotonic() + PATIENCE_S
        while time.monotonic() < until:
            found = next((message for message in list(self.received) if wanted(message)), None)
            if found is not None:
                return found
            time.sleep(0.01)
        raise AssertionError(f"no such message; the last ones: {self.received[-5:]}")

    def opened(self) -> None:
        """Forgets what was there, and waits for nothing: to be called before a page is opened."""
        self.received.clear()
        self.refuse = False

    def stop(self) -> None:
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join(PATIENCE_S)

    def _do(self, coroutine: Any) -> None:
        asyncio.run_coroutine_threadsafe(coroutine, self.loop).result(PATIENCE_S)

    async def _send(self, message: dict[str, Any] | bytes) -> None:
        if isinstance(message, bytes):
            await self.sockets[-1].send_bytes(message)
        else:
            await self.sockets[-1].send_str(json.dumps(message))

    def _run(self, started: threading.Event) -> None:
        asyncio.set_event_loop(self.loop)
        app = web.Application()
        app.router.add_get("/ws", self._socket)
        app.router.add_get("/", self._file)
        app.router.add_get("/web/{name}", self._file)
        runner = web.AppRunner(app, shutdown_timeout=0.1)
        self.loop.run_until_complete(runner.setup())
        site = web.TCPSite(runner, "127.0.0.1", 0)
        self.loop.run_until_complete(site.start())
        self.port = runner.addresses[0][1]
        started.set()
        self.loop.run_forever()
        self.loop.run_until_complete(runner.cleanup())

    async def _file(self, request: web.Request) -> web.Response:
        name = request.match_info.get("name", "index.html")
        own = name == "texts.json"
        text = read_texts().page_json() if own else (WEB / name).read_text(encoding="utf-8")
        headers = {"Content-Security-Policy": CSP, "Cache-Control": "no-store"}
        return web.Response(text=text, content_type=TYPES[Path(name).suffix], headers=headers)

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        if self.refuse:
            return web.Response(status=409)
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        self.sockets.append(socket)
        async for message in socket:
            if message.type is WSMsgType.TEXT:
                self.received.append(json.loads(message.data))
        return socket
