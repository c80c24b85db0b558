"""The websocket as programs use and abuse it; nothing that comes in may stop the simulation."""

import asyncio
import contextlib
import json

import aiohttp
import pytest
from live_cast import SpyCast
from live_server import Client, live_server, until

from hv_live import server as server_module
from hv_live.server import is_loopback


def play(test, tmp_path, **options):
    """Runs `test(server, session, client)` with a visitor who steers."""

    async def main():
        async with live_server(tmp_path, **options) as server, aiohttp.ClientSession() as session:
            async with session.ws_connect(f"http://127.0.0.1:{server.port}/live") as socket:
                await test(server, session, Client(socket))

    asyncio.run(main())


def test_a_visitor_steers_and_a_second_one_watches(tmp_path):
    cast = SpyCast()

    async def test(server, session, client):
        await until(lambda: client.pictures and client.last("state"))
        assert client.last("hello")["policies"] == ["reader", "teacher"]
        assert client.last("room")["task"] == "living_room_1"
        assert client.last("role") == {"type": "role", "steers": True, "visitors": 1}
        assert client.last("notice")["text"] == cast.warning
        async with session.ws_connect(f"http://127.0.0.1:{server.port}/live") as second:
            watcher = Client(second)
            await until(lambda: watcher.pictures and watcher.last("room"))
            assert not watcher.last("role")["steers"]
            await watcher.say("instruct", text="from the watcher")
            assert "watching" in (await until(lambda: watcher.last("error")))["text"]
            await client.say("instruct", text="from the one who steers")
            await until(lambda: watcher.last("state").get("told") == "from the one who steers")
            assert "from the watcher" not in cast.actors["reader"].told
            await client.socket.close()
            await until(lambda: watcher.last("role")["steers"])
            await watcher.say("instruct", text="now it is my turn")
            await until(lambda: watcher.last("state").get("told") == "now it is my turn")

    play(test, tmp_path, cast=cast)


def test_every_control(tmp_path):
    async def test(server, session, client):
        async def state(condition):
            return await until(lambda: condition(client.last("state")) and client.last("state"))

        await state(lambda s: s.get("step", 0) > 5)
        await client.say("pause", on=True)
        await state(lambda s: s["paused"])
        step = server.session.simulation.world.episode_step[0].item()
        before = len(client.pictures)
        await client.say("camera", azimuth_deg=10, elevation_deg=-30, distance_m=2)
        seen = await state(lambda s: s["camera"]["elevation_deg"] == -30)
        assert not seen["camera"]["home"]
        await until(lambda: len(client.pictures) > before)
        assert server.session.simulation.world.episode_step[0].item() == step
        await client.say("camera_home")
        await state(lambda s: s["camera"]["home"])
        await client.say("pause", on=False)
        await state(lambda s: s["step"] > step)

        await client.say("record", on=True)
        await state(lambda s: (s["recording"] or 0) > 5)
        await client.say("record", on=False)
        await until(lambda: "Recorded 1 episodes" in client.last("notice").get("text", ""), 40)
        assert len(list(tmp_path.glob("live_*/meta/info.json"))) == 1

        await client.say("instructor", on=True)
        await state(lambda s: s["instructor"])
        await client.say("policy", name="teacher")
        await state(lambda s: s["policy"] == "teacher")
        await client.say("instruct", text="dance")
        assert "needs an object" in (await until(lambda: client.last("error")))["text"]
        await client.say("push", direction_deg=90)
        await client.say("reset")
        await state(lambda s: s["step"] < 20)
        await client.say("load", task="living_room_3")
        await until(lambda: client.last("room")["task"] == "living_room_3")
        assert (await state(lambda s: s["step"] > 2))["policy"] == "teacher", "who plays stays"
        await client.say("load", task="moon")
        await until(lambda: "'moon'" in client.last("error")["text"])

    play(test, tmp_path)


def test_who_leaves_frees_the_simulation(tmp_path):
    async def test(server, session, client):
        await until(lambda: client.pictures)
        await client.say("record", on=True)
        await until(lambda: (client.last("state")["recording"] or 0) > 3)
        await client.socket.close()
        await until(lambda: server.session.simulation is None)
        async with session.get(f"http://127.0.0.1:{server.port}/status") as answer:
            assert (await answer.json())["simulation"] == "idle"
        await until(lambda: list(tmp_path.glob("live_*")), 40)  # what was recorded is kept
        async with session.ws_connect(f"http://127.0.0.1:{server.port}/live") as socket:
            again = Client(socket)
            await until(lambda: again.pictures and again.last("state"))
            assert again.last("role")["steers"]

    play(test, tmp_path)


def test_junk_leaves_it_running(tmp_path):
    """Wrong types, bytes, 10 MB, a flood: each ends with an answer or a closed line, and others are served."""

    async def test(server, session, client):
        url = f"http://127.0.0.1:{server.port}/live"
        await until(lambda: client.pictures)
        for junk in ("", "null", "[]", '{"type": 1}', '{"type": "instruct", "text": {}}', "[" * 4000):
            await client.socket.send_str(junk)
        await client.socket.send_bytes(b"\x00\xff" * 100)
        await until(lambda: len(client.heard.get("error", [])) >= 7)

        async with session.ws_connect(url) as huge:
            with_ten_megabytes = Client(huge)
            with contextlib.suppress(ConnectionError, aiohttp.ClientError):  # shown out before it has said it all
                await huge.send_str("x" * 10_000_000)
            await until(lambda: huge.closed)
            assert with_ten_megabytes.last("hello")

        camera = {"azimuth_deg": 1, "elevation_deg": -10, "distance_m": 3}
        for _ in range(80):
            await client.say("camera", **camera)
        await until(lambda: "Too many messages" in client.last("error")["text"])
        assert not client.socket.closed
        for _ in range(200):
            await client.say("camera", **camera)
        await until(lambda: client.socket.closed)
        assert client.socket.close_code == 1008

        async with session.post(f"http://127.0.0.1:{server.port}/", data=b"\x00" * 2_000_000) as answer:
            assert answer.status == 405
        async with session.ws_connect(url) as socket:
            other = Client(socket)
            step = (await until(lambda: other.last("state")))["step"]
            await until(lambda: other.last("state")["step"] > step)

    play(test, tmp_path)


def test_half_open_sockets_and_crowds(tmp_path, monkeypatch):
    """200 silent connections leave room for a visitor and are closed; 200 websockets are not all let in."""
    monkeypatch.setattr(server_module, "SILENT_S", 1.0)

    async def test(server, session, client):
        silent = [await asyncio.open_connection("127.0.0.1", server.port) for _ in range(200)]
        for number, (_, writer) in enumerate(silent):
            writer.write((b"", b"GET /live HTT", b"\xff\x00 junk\r\n\r\n")[number % 3])
        async with session.get(f"http://127.0.0.1:{server.port}/") as answer:
            assert answer.status == 200
        for reader, _ in silent:
            await asyncio.wait_for(reader.read(), 10)
        await asyncio.gather(*(close(writer) for _, writer in silent))

        async def knock():
            try:
                return await session.ws_connect(f"http://127.0.0.1:{server.port}/live")
            except aiohttp.WSServerHandshakeError as refused:
                return refused.status

        answers = await asyncio.gather(*(knock() for _ in range(200)))
        sockets = [answer for answer in answers if not isinstance(answer, int)]
        assert len(sockets) == server_module.MAX_VISITORS - 1
        assert {answer for answer in answers if isinstance(answer, int)} == {503}
        step = client.last("state")["step"]
        await until(lambda: client.last("state")["step"] > step)
        await asyncio.gather(*(s.close() for s in sockets))
        await until(lambda: len(server.visitors) == 1)

    async def close(writer):
        writer.close()

    play(test, tmp_path)


def test_other_sites_and_strangers_stay_outside(tmp_path):
    async def main():
        async with live_server(tmp_path, host="0.0.0.0") as server, aiohttp.ClientSession() as session:
            root = f"http://127.0.0.1:{server.port}"
            assert server.token in server.url
            for path in ("/", "/status", "/page/main.js", "/live", "/?token=wrong"):
                async with session.get(root + path) as answer:
                    assert answer.status == 403
            async with session.get(f"{root}/?token={server.token}", allow_redirects=False) as answer:
                assert (answer.status, answer.headers["Location"]) == (302, "/")
                cookie = answer.cookies["hv_live"]
                assert cookie["httponly"]
                given = {"Cookie": f"hv_live={cookie.value}"}
            async with session.get(root + "/", headers=given) as answer:
                assert answer.status == 200
            with pytest.raises(aiohttp.WSServerHandshakeError):
                await session.ws_connect(root + "/live", headers={**given, "Origin": "http://elsewhere.example"})
            async with session.ws_connect(root + "/live", headers=given) as socket:
                assert json.loads((await socket.receive()).data)["type"] == "hello"

        async with live_server(tmp_path) as server, aiohttp.ClientSession() as session:
            root = f"http://127.0.0.1:{server.port}"
            assert server.token == ""
            async with session.get(root + "/", headers={"Host": "elsewhere.example"}) as answer:
                assert answer.status == 403
            async with session.get(root + "/") as answer:
                assert answer.status == 200
                assert "script-src 'self'" in answer.headers["Content-Security-Policy"]
            for path in ("/page/nothing.js", "/page/..%2f__init__.py", "/page/__init__.py"):
                async with session.get(root + path) as answer:
                    assert answer.status == 404

    asyncio.run(main())


def test_loopback():
    assert all(is_loopback(host) for host in ("127.0.0.1", "127.3.2.1", "::1", "localhost"))
    assert not any(is_loopback(host) for host in ("0.0.0.0", "::", "10.0.0.2", "localhost.example", ""))
