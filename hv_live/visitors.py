"""Who looks at the page: one steers, the others watch; to each goes what is newest, however slow the line."""

from __future__ import annotations

import asyncio
import json
from collections import deque
from collections.abc import Iterator
from typing import Any

from aiohttp import web

from hv_live.protocol import Allowance

MOST_TEXTS = 40
"""Messages that wait for a slow visitor; the oldest go first."""


class Visitor:
    """One websocket: what waits to be sent there, and how much it may still ask for.

    Args:
        socket: open.
    """

    def __init__(self, socket: web.WebSocketResponse) -> None:
        self.socket = socket
        self.allowance = Allowance()
        self._texts: deque[str] = deque(maxlen=MOST_TEXTS)
        self._state: str | None = None
        self._picture: bytes | None = None
        self._something = asyncio.Event()

    def offer(self, message: dict[str, Any] | bytes) -> None:
        """Has a message sent when the line is free; an older picture or state that still waits is given up."""
        if isinstance(message, bytes):
            self._picture = message
        elif message["type"] == "state":
            self._state = json.dumps(message)
        else:
            self._texts.append(json.dumps(message))
        self._something.set()

    async def keep_sending(self) -> None:
        """Sends what is offered until it is cancelled or the line breaks."""
        while True:
            await self._something.wait()
            self._something.clear()
            while self._texts:
                await self.socket.send_str(self._texts.popleft())
            if self._state is not None:
                state, self._state = self._state, None
                await self.socket.send_str(state)
            if self._picture is not None:
                picture, self._picture = self._picture, None
                await self.socket.send_bytes(picture)


class Visitors:
    """Everybody who is there, in the order in which they came; the first one steers."""

    def __init__(self) -> None:
        self._present: list[Visitor] = []

    def __len__(self) -> int:
        return len(self._present)

    def __iter__(self) -> Iterator[Visitor]:
        return iter(list(self._present))

    def steers(self, visitor: Visitor) -> bool:
        """Whether it is the one who steers."""
        return bool(self._present) and self._present[0] is visitor

    def enter(self, visitor: Visitor) -> None:
        """Somebody comes."""
        self._present.append(visitor)
        self._tell_roles()

    def leave(self, visitor: Visitor) -> None:
        """Somebody goes; who came next steers."""
        if visitor in self._present:
            self._present.remove(visitor)
            self._tell_roles()

    def offer(self, message: dict[str, Any] | bytes) -> None:
        """Offers a message to everybody."""
        for visitor in self._present:
            visitor.offer(message)

    def _tell_roles(self) -> None:
        for visitor in self._present:
            visitor.offer({"type": "role", "steers": self.steers(visitor), "visitors": len(self._present)})
