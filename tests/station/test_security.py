"""Who is refused: each over a real connection to a station whose rig only listens."""

from __future__ import annotations

import asyncio
import http.client
import json
from collections.abc import Awaitable, Callable
from typing import Any

import aiohttp
import pytest

from pipeline.station.messages import MOST_BYTES
from pipeline.station.security import MESSAGES_A_SECOND, Gate
from pipeline.station.server import Server, listening_socket

HELLO = '{"type":"hello","protocol":1}'


class Ear:
    """A rig that notes what it hears."""

    def __init__(self) -> None:
        self.events: asyncio.Queue[Any] = asyncio.Queue()
        self.link: Any = None
        self.messages: list[Any] = []
        self.gone = 0

    def connect(self, link: Any) -> None:
        self.link = link
        link.say({"type": "page", "name": "consent", "data": {}})

    def disconnect(self) -> None:
        self.link, self.gone = None, self.gone + 1

    def heard(self, message: Any) -> None:
        self.messages.append(message)


class Visit:
    """A station and ways to come to it."""

    def __init__(self) -> None:
        self.ear = Ear()
        self._listening = listening_socket(0)
        self.gate = Gate(self._listening.getsockname()[1])
        self.server = Server(self.ear, self.gate, "{}")  # type: ignore[arg-type]
        self.port = self.gate.port
        self.origin = f"http://127.0.0.1:{self.port}"
        self.session: aiohttp.ClientSession

    async def __aenter__(self) -> Visit:
        await self.server.start(self._listening)
        self.session = aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True))
        return self

    async def __aexit__(self, *error: object) -> None:
        await self.session.close()
        await self.server.stop()

    async def get(self, path: str, headers: dict[str, str] | None = None) -> tuple[int, dict[str, str], str]:
        """Status, headers and text of a plain request, whose Host and Origin are as given."""

        def ask() -> tuple[int, dict[str, str], str]:
            connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=10)
            connection.request("GET", path, headers=headers or {})
            answer = connection.getresponse()
            text = answer.read().decode()
            return answer.status, {k.lower(): v for k, v in answer.getheaders()}, text

        return await asyncio.to_thread(ask)

    async def come_in(self) -> None:
        """Comes by the link, as the first browser does."""
        async with self.session.get(self.gate.link) as answer:
            assert answer.status == 200

    def socket(self, origin: str | None = None, **more: str) -> Any:
        """A WebSocket with the session's cookies."""
        headers = {"Origin": origin or self.origin, **more}
        return self.session.ws_connect(f"ws://127.0.0.1:{self.port}/ws", headers=headers)

    async def refused(self, opening: Any) -> int:
        """The status with which a WebSocket is refused."""
        with pytest.raises(aiohttp.WSServerHandshakeError) as told:
            async with opening:
                pass
        return told.value.status


def visit(script: Callable[[Visit], Awaitable[None]]) -> None:
    async def run() -> None:
        async with Visit() as here:
            await script(here)

    asyncio.run(asyncio.wait_for(run(), 60))


def test_the_link_opens_once() -> None:
    async def script(here: Visit) -> None:
        path = here.gate.link.removeprefix(here.origin)
        status, headers, _ = await here.get(path)
        assert status == 303 and headers["location"] == "/"
        cookie = headers["set-cookie"]
        assert "HttpOnly" in cookie and "SameSite=Strict" in cookie
        assert (await here.get(path))[0] == 403
        assert (await here.get("/", {"Cookie": cookie.split(";")[0]}))[0] == 200

    visit(script)


@pytest.mark.parametrize(
    "path", ["/?token=", "/?token=guess", "/?token=%00%ff", "/", "/web/main.js", "/web/texts.json"]
)
def test_without_the_right_token_or_its_cookie_there_is_nothing(path: str) -> None:
    async def script(here: Visit) -> None:
        status, _, text = await here.get(path)
        assert status == 403 and "<" not in text

    visit(script)


@pytest.mark.parametrize(
    "host", ["evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil.example:{port}", ""]
)
def test_a_foreign_host_is_refused(host: str) -> None:
    async def script(here: Visit) -> None:
        path = here.gate.link.removeprefix(here.origin)
        assert (await here.get(path, {"Host": host.format(port=here.port)}))[0] in (400, 421)
        # the token is still unused
        assert (await here.get(path, {"Host": f"localhost:{here.port}"}))[0] == 303

    visit(script)


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "https://127.0.0.1:{port}", "http://127.0.0.1"]
)
def test_a_foreign_origin_is_refused(origin: str) -> None:
    async def script(here: Visit) -> None:
        await here.come_in()
        foreign = origin.format(port=here.port)
        assert (await here.get("/", {"Origin": foreign}))[0] == 403
        assert await here.refused(here.socket(origin=foreign)) == 403
        assert await here.refused(here.socket(Host="evil.example")) == 421

    visit(script)


def test_a_websocket_without_origin_or_without_token_is_refused() -> None:
    async def script(here: Visit) -> None:
        assert await here.refused(here.socket()) == 403  # no cookie yet
        await here.come_in()
        address = f"ws://127.0.0.1:{here.port}/ws"
        assert await here.refused(here.session.ws_connect(address)) == 403
        async with here.socket() as page:
            await page.send_str(HELLO)
            assert json.loads((await page.receive(5)).data)["name"] == "consent"

    visit(script)


def test_a_second_controller_is_refused_while_the_first_is_there() -> None:
    async def script(here: Visit) -> None:
        await here.come_in()
        async with here.socket() as page:
            await page.send_str(HELLO)
            await page.receive(5)
            assert await here.refused(here.socket()) == 409
            await page.send_str('{"type":"button","name":"a"}')
        await asyncio.wait_for(here.server.left.wait(), 5)
        assert len(here.ear.messages) == 1 and here.ear.gone == 1
        async with here.socket() as page:
            await page.send_str(HELLO)
            await page.receive(5)

    visit(script)


MALFORMED = [
    "",
    "no json",
    "[]",
    '{"type":"hello","protocol":1}',  # a second one
    '{"type":"input","seq":1,"left":[0,0],"right":[0],"source":"gamepad","device":""}',
    '{"type":"input","seq":1,"left":[0,2],"right":[0,0],"source":"gamepad","device":""}',
    '{"type":"input","seq":1,"left":[0,NaN],"right":[0,0],"source":"gamepad","device":""}',
    '{"type":"input","seq":-1,"left":[0,0],"right":[0,0],"source":"gamepad","device":""}',
    '{"type":"input","seq":1,"left":[0,0],"right":[0,0],"source":"mouse","device":""}',
    '{"type":"input","seq":"1","left":[0,0],"right":[0,0],"source":"gamepad","device":""}',
    '{"type":"button","name":"quit"}',
    '{"type":"button","name":"a","more":1}',
    '{"type":"answer","page":"../../x","values":{}}',
    '{"type":"answer","page":"tlx","values":{"mental":101}}',
    '{"type":"answer","page":"ready","values":{"more":1}}',
    '{"type":"drawn","frame":1,"latency_ms":-5}',
    "[" * 2000,
    '{"type":"button","name":"a"}' + " " * MOST_BYTES,
    b"\x00\x01",
]


@pytest.mark.parametrize("message", MALFORMED, ids=range(len(MALFORMED)))
def test_a_malformed_or_oversized_message_ends_the_connection(message: str | bytes) -> None:
    async def script(here: Visit) -> None:
        await here.come_in()
        async with here.socket() as page:
            await page.send_str(HELLO)
            await page.receive(5)
            await (page.send_bytes(message) if isinstance(message, bytes) else page.send_str(message))
            assert (await page.receive(5)).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)
            assert page.close_code == (1009 if len(message) > MOST_BYTES else 1008)
        assert not here.ear.messages and here.ear.events.empty()

    visit(script)


@pytest.mark.parametrize("greeting", ['{"type":"hello","protocol":2}', '{"type":"button","name":"a"}', "x"])
def test_the_first_message_is_a_hello_of_this_protocol(greeting: str) -> None:
    async def script(here: Visit) -> None:
        await here.come_in()
        async with here.socket() as page:
            await page.send_str(greeting)
            await page.receive(5)
            assert page.close_code == 1008
        assert here.ear.link is None and here.ear.gone == 0

    visit(script)


def test_a_page_that_floods_is_disconnected() -> None:
    async def script(here: Visit) -> None:
        await here.come_in()
        async with here.socket() as page:
            await page.send_str(HELLO)
            await page.receive(5)
            for _ in range(4 * MESSAGES_A_SECOND):
                try:
                    await page.send_str('{"type":"button","name":"a"}')
                except ConnectionError:
                    break
            assert (await page.receive(5)).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED)
        assert len(here.ear.messages) < 4 * MESSAGES_A_SECOND

    visit(script)


@pytest.mark.parametrize(
    "path",
    [
        "/web/../params.yaml",
        "/web/%2e%2e%2fparams.yaml",
        "/web/..%2f..%2fetc%2fpasswd",
        "/web//etc/passwd",
        "/web/%2fetc%2fpasswd",
        "/web/texts.yaml",
        "/web/",
        "/study",
        "/favicon.ico",
    ],
)
def test_no_name_in_a_request_reaches_the_file_system(path: str) -> None:
    async def script(here: Visit) -> None:
        _, headers, _ = await here.get(here.gate.link.removeprefix(here.origin))
        status, _, text = await here.get(path, {"Cookie": headers["set-cookie"].split(";")[0]})
        assert status == 404 and "root:" not in text and "viewpoints" not in text

    visit(script)


def test_every_answer_has_a_strict_policy_and_is_not_kept() -> None:
    async def script(here: Visit) -> None:
        link = here.gate.link.removeprefix(here.origin)
        answers = [await here.get(path) for path in (link, "/", "/none", "/?token=x")]
        cookie = answers[0][1]["set-cookie"].split(";")[0]
        answers.append(await here.get("/", {"Cookie": cookie}))
        for _, headers, _ in answers:
            policy = headers["content-security-policy"]
            assert "default-src 'none'" in policy and "unsafe" not in policy and "frame-ancestors" in policy
            assert headers["cache-control"] == "no-store"
            assert headers["x-content-type-options"] == "nosniff"
            assert headers["referrer-policy"] == "no-referrer"

    visit(script)


def test_it_listens_on_the_loopback_address_only() -> None:
    listening = listening_socket(0)
    assert listening.getsockname()[0] == "127.0.0.1"
    listening.close()


def test_a_taken_port_is_told_in_a_sentence() -> None:
    from pipeline.contract.errors import BelvedereError

    first = listening_socket(0)
    with pytest.raises(BelvedereError, match="cannot be listened at"):
        listening_socket(first.getsockname()[1])
    first.close()
