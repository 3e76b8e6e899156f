"""Chromium by its DevTools protocol, over the WebSocket that it opens itself: keys, fingers, and what a page shows."""

import asyncio
import json
import shutil
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tornado.websocket import WebSocketClientConnection, websocket_connect

from tests.sil.rig import PATIENCE_SECONDS
from tests.unit.offline.browser import CHROMIUM


class Tab:
    """The one tab of a browser; the protocol is https://chromedevtools.github.io/devtools-protocol/."""

    def __init__(self, loop: asyncio.AbstractEventLoop, connection: WebSocketClientConnection) -> None:
        self._loop, self._connection, self._number = loop, connection, 0

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Call a method of the protocol and return its result."""
        return self._loop.run_until_complete(asyncio.wait_for(self._call(method, parameters), PATIENCE_SECONDS))

    async def _call(self, method: str, parameters: dict[str, Any]) -> dict[str, Any]:
        self._number += 1
        number = self._number
        await self._connection.write_message(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            text = await self._connection.read_message()
            assert text is not None, "Chromium has ended"
            reply = json.loads(text)
            if reply.get("id") == number:
                assert "error" not in reply, reply
                result: dict[str, Any] = reply["result"]
                return result

    def open(self, url: str) -> None:
        """Open a page and wait until it is loaded."""
        self.call("Page.navigate", url=url)
        self.until("document.readyState === 'complete' && location.href !== 'about:blank'")

    def get(self, expression: str) -> Any:
        """Evaluate JavaScript; promises are awaited."""
        found = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in found, found
        return found["result"].get("value")

    def text(self, name: str) -> str:
        """Text of an element by its id."""
        return str(self.get(f"document.getElementById('{name}').textContent"))

    def until(self, expression: str) -> None:
        """Wait until JavaScript is true."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not self.get(expression):
            assert time.monotonic() < deadline, f"{expression}: {self.get('document.body.innerText')}"
            time.sleep(0.02)

    def press(self, code: str, key: str) -> None:
        """Press a key, and release it."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, code=code, key=key, text=key if kind == "keyDown" else "")

    def mouse(self, kind: str, name: str) -> None:
        """Press or release the mouse in the middle of an element, such as "mousePressed"."""
        self.get(f"document.getElementById('{name}').scrollIntoView({{block: 'center'}})")
        box = self.get(f"(r => [r.x + r.width / 2, r.y + r.height / 2])({name_box(name)})")
        self.call("Input.dispatchMouseEvent", type=kind, x=box[0], y=box[1], button="left", clickCount=1)

    def click(self, name: str) -> None:
        """Click on an element."""
        self.mouse("mousePressed", name)
        self.mouse("mouseReleased", name)

    def resize(self, width: int, height: int, *, mobile: bool) -> None:
        """Show the page on a screen of this size [CSS pixels]."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=2, mobile=mobile)


def name_box(name: str) -> str:
    """JavaScript for the place of an element."""
    return f"document.getElementById('{name}').getBoundingClientRect()"


@contextmanager
def chromium(folder: Path) -> Iterator[Tab]:
    """Yield a tab of a browser without a screen that resolves no name but localhost; it ends with the block."""
    assert CHROMIUM is not None
    profile = folder / "profile"
    command = [
        *(CHROMIUM, "--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run", f"--user-data-dir={profile}"),
        *("--remote-debugging-port=0", "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost, EXCLUDE 127.0.0.1"),
        *("--disable-background-timer-throttling", "--disable-renderer-backgrounding", "--window-size=1000,800"),
        "about:blank",
    ]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    loop = asyncio.new_event_loop()
    connection: WebSocketClientConnection | None = None
    try:
        port = _port(profile / "DevToolsActivePort")
        connection = loop.run_until_complete(_connect(port))
        yield Tab(loop, connection)
    finally:
        if connection is not None:
            connection.close()
            loop.run_until_complete(asyncio.sleep(0.05))
        loop.close()
        process.terminate()
        process.wait(timeout=30.0)
        shutil.rmtree(profile, ignore_errors=True)


def _port(file: Path) -> int:
    """Wait for the port that the browser writes down."""
    deadline = time.monotonic() + PATIENCE_SECONDS
    while not (file.exists() and (lines := file.read_text().splitlines())):
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return int(lines[0])


async def _connect(port: int) -> WebSocketClientConnection:
    """Connect to the first page."""
    from tornado.httpclient import AsyncHTTPClient

    deadline = time.monotonic() + PATIENCE_SECONDS
    while True:
        reply = await AsyncHTTPClient().fetch(f"http://127.0.0.1:{port}/json/list")
        pages = [one for one in json.loads(reply.body) if one["type"] == "page"]
        if pages:
            return await websocket_connect(pages[0]["webSocketDebuggerUrl"], max_message_size=1 << 26)
        assert time.monotonic() < deadline
        await asyncio.sleep(0.05)
