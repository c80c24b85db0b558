"""The page and its websocket (aiohttp): one simulation, one who steers, others who watch.

Open to this machine alone; elsewhere it takes a token, which the printed address carries. Nothing that comes in is
trusted: messages are small, counted and checked, the number of sockets is bounded, silent ones are closed.
"""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import ipaddress
import secrets
import time
from collections.abc import Awaitable, Callable
from importlib.resources import files
from typing import Any
from urllib.parse import urlsplit

from aiohttp import WSMsgType, web

from hv_live.protocol import MAX_MESSAGE_BYTES, ProtocolError, cost, parse_command
from hv_live.session import Session
from hv_live.visitors import Visitor, Visitors

MAX_SOCKETS, MAX_VISITORS = 256, 16
SILENT_S = 15.0
"""A socket that has not said what it wants by then is closed."""
HEARTBEAT_S = 10.0
END_S = 2.0
"""So long the server waits at its end for what is still being answered."""
MAX_BAD_MESSAGES = 50
"""So many messages that are not understood, or too many, and the visitor is shown out."""
_COOKIE = "hv_live"
_PAGE = {
    "index.html": "text/html",
    "style.css": "text/css",
    "main.js": "text/javascript",
    "link.js": "text/javascript",
    "room_map.js": "text/javascript",
    "orbit.js": "text/javascript",
    "icon.svg": "image/svg+xml",
}
_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


class LiveServer:
    """Serves one session.

    Args:
        make_session: builds it; is given what to call, from any thread, with each message for the page.
        hello: what a visitor is told at first (`type` is added): the rooms and the policies.
        host: address to listen on.
        port: 0 for any that is free.
    """

    def __init__(
        self,
        make_session: Callable[[Callable[[dict[str, Any] | bytes], None]], Session],
        hello: dict[str, Any],
        host: str = "127.0.0.1",
        port: int = 0,
    ) -> None:
        self.host, self.port = host, port
        self.token = "" if is_loopback(host) else secrets.token_urlsafe(18)
        self.visitors = Visitors()
        self._hello = {"type": "hello", **hello}
        self._make_session = make_session
        self.session: Session | None = None
        self._files = {name: files("hv_live").joinpath("page", name).read_bytes() for name in _PAGE}
        self._listener: asyncio.Server | None = None
        self._runner: web.AppRunner | None = None

    @property
    def url(self) -> str:
        """Where the page is, with the token if it takes one."""
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"http://{host}:{self.port}/" + (f"?token={self.token}" if self.token else "")

    async def start(self) -> None:
        """Begins to listen.

        Raises:
            OSError: the address is not free or not of this machine.
        """
        app = web.Application(middlewares=[self._guard], client_max_size=MAX_MESSAGE_BYTES)
        app.router.add_get("/", self._index)
        app.router.add_get("/page/{name}", self._page)
        app.router.add_get("/status", self._status)
        app.router.add_get("/live", self._live)
        self._runner = web.AppRunner(app, keepalive_timeout=SILENT_S, access_log=None, shutdown_timeout=END_S)
        await self._runner.setup()
        protocols = self._runner.server
        assert protocols is not None
        loop = asyncio.get_running_loop()

        def accept() -> asyncio.BaseProtocol:
            return protocols() if len(protocols.connections) < MAX_SOCKETS else _Refusal()

        self._listener = await loop.create_server(accept, self.host, self.port, backlog=512)
        self.port = self._listener.sockets[0].getsockname()[1]
        self.session = self._make_session(lambda message: _call(loop, self.visitors.offer, message))

    async def stop(self) -> None:
        """Shows everybody out and frees the simulation."""
        if self._listener is not None:
            self._listener.close()
        for visitor in self.visitors:
            await visitor.socket.close()
        if self._runner is not None:
            await self._runner.cleanup()
        if self.session is not None:
            await asyncio.to_thread(self.session.close)

    # who may come in

    @web.middleware
    async def _guard(
        self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]
    ) -> web.StreamResponse:
        refusal = self._refusal(request)
        if refusal is None and self.token and "token" in request.query:
            response: web.StreamResponse = web.Response(status=302, headers={"Location": "/"})
            response.set_cookie(_COOKIE, self.token, httponly=True, samesite="Strict")
        elif refusal is None:
            response = await handler(request)
        else:
            response = web.Response(status=403, text=refusal + "\n")
        if not response.prepared:
            response.headers.update(_HEADERS)
        return response

    def _refusal(self, request: web.Request) -> str | None:
        """Why a request is refused: other sites' pages must not reach in, and strangers have no token."""
        host = request.headers.get("Host", "")
        if not self.token and not is_loopback(urlsplit(f"//{host}").hostname or ""):
            return "host: not of this machine; open the address that hv-live printed"
        origin = request.headers.get("Origin")
        if origin is not None and urlsplit(origin).netloc != host:
            return "origin: another site; open the address that hv-live printed"
        if self.token:
            given = request.query.get("token") or request.cookies.get(_COOKIE, "")
            if not hmac.compare_digest(given.encode(), self.token.encode()):
                return "token: missing or wrong; open the address that hv-live printed"
        return None

    # what is there

    async def _index(self, request: web.Request) -> web.Response:
        return self._file("index.html")

    async def _page(self, request: web.Request) -> web.Response:
        name = request.match_info["name"]
        if name not in _PAGE:
            raise web.HTTPNotFound
        return self._file(name)

    def _file(self, name: str) -> web.Response:
        return web.Response(body=self._files[name], content_type=_PAGE[name], charset="utf-8")

    async def _status(self, request: web.Request) -> web.Response:
        live = self.session.simulation if self.session is not None else None
        return web.json_response(
            {
                "simulation": "idle" if live is None else live.task.name,
                "visitors": len(self.visitors),
                "step": 0 if live is None else int(live.world.episode_step[0]),
            }
        )

    async def _live(self, request: web.Request) -> web.StreamResponse:
        if len(self.visitors) >= MAX_VISITORS:
            return web.Response(status=503, text=f"visitors: {MAX_VISITORS} are here already\n")
        socket = web.WebSocketResponse(
            heartbeat=HEARTBEAT_S, timeout=END_S, max_msg_size=MAX_MESSAGE_BYTES, compress=False
        )
        await socket.prepare(request)
        assert self.session is not None
        visitor = Visitor(socket)
        visitor.offer(self._hello)
        self.visitors.enter(visitor)
        self.session.set_visitors(len(self.visitors))
        self.session.introduce()
        sending = asyncio.create_task(visitor.keep_sending())
        try:
            await self._listen(visitor)
        finally:
            self.visitors.leave(visitor)
            self.session.set_visitors(len(self.visitors))
            sending.cancel()
            with contextlib.suppress(asyncio.CancelledError, ConnectionError):
                await sending
        return socket

    async def _listen(self, visitor: Visitor) -> None:
        bad = 0
        async for message in visitor.socket:
            if message.type != WSMsgType.TEXT:
                problem = "message: not text"
            else:
                problem = self._hear(visitor, message.data)
            if problem:
                bad += 1
                visitor.offer({"type": "error", "text": problem})
            if bad > MAX_BAD_MESSAGES:
                await visitor.socket.close(code=1008, message=b"too many bad messages")
                return

    def _hear(self, visitor: Visitor, text: str) -> str:
        """Passes a message on; says what is wrong with it, or nothing."""
        if not self.visitors.steers(visitor):
            return "You are watching: another visitor steers, until they leave."
        if not visitor.allowance.take(1.0, time.monotonic()):
            return "Too many messages: slow down."
        try:
            command = parse_command(text)
        except ProtocolError as error:
            return str(error)
        if not visitor.allowance.take(cost(command) - 1.0, time.monotonic()):
            return "Too many messages: slow down."
        assert self.session is not None
        return "" if self.session.send(command) else "The simulation is busy: try again in a moment."


class _Refusal(asyncio.Protocol):
    """One socket too many."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        assert isinstance(transport, asyncio.Transport)
        transport.abort()


def is_loopback(host: str) -> bool:
    """Whether a host name means this machine and nothing else."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def _call(loop: asyncio.AbstractEventLoop, function: Callable[..., None], *arguments: Any) -> None:
    """Has the loop call something; nothing happens when it has ended meanwhile."""
    try:
        loop.call_soon_threadsafe(function, *arguments)
    except RuntimeError:
        if not loop.is_closed():
            raise
