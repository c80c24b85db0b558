"""A server of hv-live for tests, in this process: two rooms, actors that load nothing, a short memory of who left."""

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import aiohttp
from live_cast import SpyCast

from hv_live.rooms_on_offer import catalogue
from hv_live.server import LiveServer
from hv_live.session import Session
from hv_sim.task import load_task


@asynccontextmanager
async def live_server(recordings: Path, cast: Any = None, host: str = "127.0.0.1") -> AsyncIterator[LiveServer]:
    cast = SpyCast() if cast is None else cast
    tasks = {name: load_task(name) for name in ("living_room_1", "living_room_3")}
    server = LiveServer(
        lambda publish: Session(tasks, "living_room_1", cast, recordings, publish, linger_s=0.2),
        {"tasks": catalogue(tasks), "policies": cast.names, "missing": list(cast.missing)},
        host=host,
    )
    await server.start()
    try:
        yield server
    finally:
        await server.stop()


class Client:
    """A visitor who keeps what was said, by type, and the newest picture."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket = socket
        self.heard: dict[str, list[dict[str, Any]]] = {}
        self.pictures: list[bytes] = []
        self._listening = asyncio.create_task(self._listen())

    async def _listen(self) -> None:
        async for message in self.socket:
            if message.type == aiohttp.WSMsgType.BINARY:
                self.pictures.append(message.data)
            elif message.type == aiohttp.WSMsgType.TEXT:
                data = message.json()
                self.heard.setdefault(data["type"], []).append(data)

    def last(self, kind: str) -> dict[str, Any]:
        """The newest message of a type, empty before the first."""
        return self.heard.get(kind, [{}])[-1]

    async def say(self, kind: str, **fields: Any) -> None:
        await self.socket.send_json({"type": kind, **fields})


async def until(condition: Callable[[], Any], timeout_s: float = 20.0) -> Any:
    """Waits for something to be true, and returns it."""
    for _ in range(round(timeout_s / 0.02)):
        if value := condition():
            return value
        await asyncio.sleep(0.02)
    raise AssertionError("it did not come true")
