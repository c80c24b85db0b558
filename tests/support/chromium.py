"""Debian's Chromium without a screen, driven over its debugging protocol: pages looked at as a person would."""

import asyncio
import base64
import contextlib
import shutil
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any

import aiohttp

MISSING = "Debian's chromium is not installed" if shutil.which("chromium") is None else ""
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run", "--hide-scrollbars", "--remote-debugging-port=0", "--disable-dev-shm-usage",
)  # fmt: skip
_KEYS = {"Enter": ("Enter", 13, "\r"), " ": ("Space", 32, " ")}


class Page:
    """A tab."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._socket = socket
        self._number = 0

    async def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """One command of the protocol."""
        self._number += 1
        await self._socket.send_json({"id": self._number, "method": method, "params": parameters})
        while True:
            answer = await self._socket.receive_json(timeout=60)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]

    async def evaluate(self, expression: str) -> Any:
        """What a line of JavaScript gives; promises are waited for."""
        result = await self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(result["exceptionDetails"])
        return result["result"].get("value")

    async def wait_for(self, expression: str, timeout_s: float = 30.0) -> Any:
        """Waits until a line of JavaScript gives something true, and returns it."""
        until = time.monotonic() + timeout_s
        while time.monotonic() < until:
            with contextlib.suppress(RuntimeError):  # the page may be loading
                if value := await self.evaluate(expression):
                    return value
            await asyncio.sleep(0.05)
        raise AssertionError(f"not within {timeout_s:g} s: {expression}")

    async def click(self, selector: str) -> None:
        """Clicks in the middle of what a selector finds."""
        box = f"document.querySelector({selector!r}).getBoundingClientRect()"
        at = await self.evaluate(f"(b => [b.x + b.width / 2, b.y + b.height / 2])({box})")
        await self._mouse("mousePressed", *at)
        await self._mouse("mouseReleased", *at)

    async def drag(self, selector: str, dx: float, dy: float) -> None:
        """Drags from the middle of what a selector finds."""
        box = f"document.querySelector({selector!r}).getBoundingClientRect()"
        x, y = await self.evaluate(f"(b => [b.x + b.width / 2, b.y + b.height / 2])({box})")
        await self._mouse("mousePressed", x, y)
        for part in (0.3, 0.6, 1.0):
            await self._mouse("mouseMoved", x + part * dx, y + part * dy)
        await self._mouse("mouseReleased", x + dx, y + dy)

    async def type(self, text: str) -> None:
        """Types into what has the focus."""
        await self.call("Input.insertText", text=text)

    async def press(self, key: str) -> None:
        """One key."""
        code, number, text = _KEYS[key] if key in _KEYS else (f"Key{key.upper()}", ord(key.upper()), key)
        common = {"key": key, "code": code, "windowsVirtualKeyCode": number}
        await self.call("Input.dispatchKeyEvent", type="keyDown", text=text, **common)
        await self.call("Input.dispatchKeyEvent", type="keyUp", **common)

    async def resize(self, width: int, height: int, *, phone: bool = False, dark: bool = False) -> None:
        """The window's size in CSS pixels."""
        await self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone
        )
        await self.call(
            "Emulation.setEmulatedMedia",
            features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}],
        )

    async def screenshot(self, path: Path) -> None:
        """Writes a PNG of what is to be seen."""
        shot = await self.call("Page.captureScreenshot", format="png")
        path.write_bytes(base64.b64decode(shot["data"]))

    async def _mouse(self, what: str, x: float, y: float) -> None:
        pressed = what != "mouseReleased"
        await self.call(
            "Input.dispatchMouseEvent", type=what, x=x, y=y, button="left", buttons=int(pressed), clickCount=1
        )


class Chromium:
    """A browser for the time of a `with`."""

    async def __aenter__(self) -> "Chromium":
        self._profile = Path(tempfile.mkdtemp(prefix="hv-chromium-"))
        command = ["chromium", *_FLAGS, f"--user-data-dir={self._profile}", "about:blank"]
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        file = self._profile / "DevToolsActivePort"
        until = time.monotonic() + 60
        while not (file.is_file() and file.read_text().strip()):
            assert time.monotonic() < until, "Chromium did not start"
            await asyncio.sleep(0.05)
        self._root = f"http://127.0.0.1:{file.read_text().splitlines()[0]}"
        self._session = aiohttp.ClientSession()
        return self

    async def open(self, url: str) -> Page:
        """A new tab."""
        async with self._session.put(f"{self._root}/json/new?{url}") as answer:
            tab = await answer.json()
        socket = await self._session.ws_connect(tab["webSocketDebuggerUrl"], max_msg_size=0)
        page = Page(socket)
        page.id = tab["id"]
        return page

    async def close(self, page: Page) -> None:
        """Closes a tab."""
        async with self._session.get(f"{self._root}/json/close/{page.id}") as answer:
            await answer.read()

    async def __aexit__(self, *_: object) -> None:
        await self._session.close()
        self._process.terminate()
        await asyncio.to_thread(self._process.wait)
        shutil.rmtree(self._profile, ignore_errors=True)
