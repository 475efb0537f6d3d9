"""Who may talk to the station: one browser of this machine, which came by the printed link."""

from __future__ import annotations

import hmac
import secrets
import time
from collections.abc import Awaitable, Callable
from typing import NoReturn

from aiohttp import web

HOST = "127.0.0.1"
HTTP_A_SECOND, MESSAGES_A_SECOND = 50, 400
_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "img-src 'self' blob:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "gamepad=(self)",
    "Cache-Control": "no-store",
    "Server": "station",
}
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Rate:
    """At most so many a second, and as many at once."""

    def __init__(self, a_second: float) -> None:
        self._a_second, self._left, self._at_s = a_second, a_second, time.monotonic()

    def allows(self) -> bool:
        """Counts one; says whether it is within the limit."""
        now_s = time.monotonic()
        self._left = min(self._a_second, self._left + (now_s - self._at_s) * self._a_second)
        self._at_s = now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class Gate:
    """The link's token, which opens once, and the cookie of the browser that came by it.

    Args:
        port: at which the station listens.
    """

    def __init__(self, port: int) -> None:
        self.port = port
        self._token: str | None = secrets.token_urlsafe(32)
        self._cookie = secrets.token_urlsafe(32)
        self._rate = Rate(HTTP_A_SECOND)
        self._hosts = {f"{HOST}:{port}", f"localhost:{port}"}
        self._origins = {f"http://{host}" for host in self._hosts}

    @property
    def link(self) -> str:
        """What is printed."""
        return f"http://{HOST}:{self.port}/?token={self._token}"

    @property
    def _name(self) -> str:
        return f"station-{self.port}"  # cookies do not tell ports apart

    def enter(self, token: str) -> NoReturn:
        """Answers a link by raising it: a cookie for the right token, once, else a refusal."""
        if self._token is None or not hmac.compare_digest(token.encode(), self._token.encode()):
            raise web.HTTPForbidden(
                text="This link was used or is no link of this station; start it again.\n"
            )
        self._token = None
        answer = web.HTTPSeeOther("/")
        answer.set_cookie(self._name, self._cookie, httponly=True, samesite="Strict", path="/")
        raise answer

    def require_cookie(self, request: web.Request) -> None:
        """Raises HTTPForbidden where the browser did not come by the link."""
        given = request.cookies.get(self._name, "")
        if not hmac.compare_digest(given.encode(), self._cookie.encode()):
            raise web.HTTPForbidden(text="Open the link that ./run station printed.\n")

    def require_origin(self, request: web.Request) -> None:
        """Raises HTTPForbidden where a page of another origin, or none at all, asks."""
        if request.headers.getall("Origin", []) not in ([origin] for origin in self._origins):
            raise web.HTTPForbidden(text="This page does not belong to the station.\n")

    @web.middleware
    async def middleware(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuses foreign hosts and origins and too many requests; puts its headers on every answer."""
        try:
            self._check(request)
            answer = await handler(request)
        except web.HTTPException as error:
            error.headers.update(_HEADERS)
            raise
        if not answer.prepared:
            answer.headers.update(_HEADERS)
        return answer

    def _check(self, request: web.Request) -> None:
        if not self._rate.allows():
            raise web.HTTPTooManyRequests(text="Too many requests.\n")
        if request.headers.getall("Host", []) not in ([host] for host in self._hosts):
            raise web.HTTPMisdirectedRequest(text="This station is not known under that name.\n")
        if "Origin" in request.headers:
            self.require_origin(request)
