"""The page in Debian's Chromium, as a visitor has it: it loads, moves, takes instructions, and lets go."""

import asyncio
import os
from pathlib import Path

import chromium
import numpy as np
import pytest
from chromium import Chromium
from live_cast import SpyCast
from live_server import live_server, until
from PIL import Image

from hv_live import protocol

pytestmark = pytest.mark.skipif(bool(chromium.MISSING), reason=chromium.MISSING)
SHOWN = "+document.body.dataset.pictures"
SHOTS = os.environ.get("HV_LIVE_SHOTS")
"""A folder for the screenshots, for whoever wants to look at them."""


def visit(test, tmp_path, **options):
    """Runs `test(server, browser, page)` with the page open and the first pictures there."""

    async def main():
        async with live_server(tmp_path, **options) as server, Chromium() as browser:
            page = await browser.open(server.url)
            await page.resize(1440, 900)
            await page.wait_for(f"{SHOWN} > 1")
            await test(server, browser, page)

    asyncio.run(main())


def text(element: str) -> str:
    return f"document.getElementById({element!r}).textContent"


def test_a_visit(tmp_path):
    """One after the other, since a browser takes its time to start."""
    cast = SpyCast()

    async def test(server, browser, page):
        # pictures change, and show something
        before = await page.evaluate(SHOWN)
        picture = "document.getElementById('{}').toDataURL()"
        old = [await page.evaluate(picture.format(view)) for view in ("third-person", "head")]
        assert all(len(data) > 20_000 for data in old)
        server.session.send(protocol.Push(0.0, 1.0))
        await page.wait_for(f"{SHOWN} > {before} + 15")
        assert old != [await page.evaluate(picture.format(view)) for view in ("third-person", "head")]

        # a typed instruction reaches the policy at the next control step, and the page shows it
        await page.press("/")
        assert await page.evaluate("document.activeElement.id") == "text"
        await page.type("please wave at me")
        await page.press("Enter")
        await page.wait_for(f"{text('instruction')} === 'please wave at me'")
        assert "please wave at me" in cast.actors["reader"].told
        assert await page.evaluate("document.getElementById('text').value") == ""
        assert "knows what these words ask for" in await page.evaluate(text("stage"))
        assert await page.evaluate("document.querySelectorAll('#said li').length") == 2

        # a suggestion, chosen
        await page.click("#suggestions button:nth-child(2)")
        second = server.session.simulation.task.subtasks[1].instruction
        await page.wait_for(f"{text('instruction')} === {second!r}")

        # pause by button, go on and reset by key
        await page.click("#pause")
        await page.wait_for("document.getElementById('pause').getAttribute('aria-pressed') === 'true'")
        step = int(server.session.simulation.world.episode_step[0])
        await asyncio.sleep(0.3)
        assert int(server.session.simulation.world.episode_step[0]) == step
        await page.evaluate("document.activeElement.blur()")
        await page.press(" ")
        await until(lambda: int(server.session.simulation.world.episode_step[0]) > step)
        await page.press("r")
        first = server.session.simulation.task.subtasks[0].instruction
        await page.wait_for(f"{text('instruction')} === {first!r}")
        assert int(server.session.simulation.world.episode_step[0]) < step + 60
        assert len(server.session.simulation.said) == 1

        # the camera is dragged, and put back
        await page.drag("#third-person", 120, 30)
        await until(lambda: server.session._orbit is not None)
        await page.wait_for("!document.getElementById('camera-home').hidden")
        await page.click("#camera-home")
        await until(lambda: server.session._orbit is None)

        # who plays; Algorithm 3; what is refused is said
        await page.click("#policies [data-name=teacher]")
        await page.wait_for("document.querySelector('[data-name=teacher]').getAttribute('aria-pressed') === 'true'")
        await page.click("#instructor")
        await until(lambda: server.session.simulation.instructor)
        await page.click("#text")
        await page.type("dance")
        await page.press("Enter")
        await page.wait_for(f"{text('notice')}.includes('The teacher needs an object and a place')")
        assert not await page.evaluate("document.getElementById('notice').hidden")

        # the map knows the room, and another room can be chosen
        assert await page.evaluate("document.querySelectorAll('#map .thing').length") == 2
        choose = "s => { s.value = 'living_room_3'; s.dispatchEvent(new Event('change')); }"
        await page.evaluate(f"({choose})(document.getElementById('task'))")
        await page.wait_for(f"{text('room-title')}.includes('living_room_3')")

        # another tab watches: nothing there can be pressed
        watcher = await browser.open(server.url)
        await watcher.wait_for(f"{SHOWN} > 1")
        assert await watcher.evaluate("document.getElementById('text').disabled")
        assert "another visitor steers" in await watcher.evaluate(text("role"))

        # tabs are closed: the other one steers, and then nobody's simulation is freed
        await browser.close(page)
        await watcher.wait_for("!document.getElementById('text').disabled")
        await browser.close(watcher)
        await until(lambda: server.session.simulation is None)

    visit(test, tmp_path, cast=cast)


@pytest.mark.parametrize(("width", "height", "dark"), [(1440, 900, False), (390, 844, True)])
def test_it_fits(tmp_path, width, height, dark):
    async def test(server, browser, page):
        await page.resize(width, height, phone=width < 500, dark=dark)
        before = await page.evaluate(SHOWN)
        await page.wait_for(f"{SHOWN} > {before} + 2")
        assert await page.evaluate("document.documentElement.scrollWidth") <= width, "nothing sticks out"
        reach = (
            "(b => b.bottom <= innerHeight && b.width > 100)(document.getElementById('text').getBoundingClientRect())"
        )
        assert await page.evaluate(reach), "the text box is to be seen without scrolling"
        shot = Path(SHOTS or tmp_path) / f"{width}.png"
        await page.screenshot(shot)
        grey = np.asarray(Image.open(shot).convert("L"))
        assert grey.shape == (height, width)
        assert grey.std() > 10
        assert (np.median(grey) < 100) == dark, "the colours that the visitor prefers"

    visit(test, tmp_path)
