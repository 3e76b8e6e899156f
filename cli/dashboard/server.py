"""The page's server: HTTP for its files and for a stop, a WebSocket for frames and requests.

A page gets the next frame once it has confirmed the last: over a slow network it shows fewer, never old ones.
"""

import asyncio
import json
import threading
from collections.abc import Callable
from typing import Any

from tornado.httpserver import HTTPServer
from tornado.iostream import StreamClosedError
from tornado.netutil import bind_sockets
from tornado.web import Application, HTTPError, RequestHandler
from tornado.websocket import WebSocketClosedError, WebSocketHandler

from tendond.cli.dashboard.access import Access
from tendond.cli.dashboard.files import FILES, PAGE

HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""No page frames this one, so no click meant for another lands on it, and none loads anything from elsewhere."""

LARGEST_MESSAGE = 16384
PAGES, REQUESTS = 16, 8
"""Pages that may be open at once, and requests beside stops that may wait at once."""

TOKEN_SECONDS = 5.0
"""Time within which a page has to give its token [s]."""

Asked = dict[str, Any]
Doer = Callable[[Asked], tuple[bool, str]]


class Hub:
    """The open pages, the newest frame, and the requests that wait.

    Args:
        access: the rule.
        carry_out: does what is asked, and waits; called on a thread for each request.
        welcome: first message to a page.
    """

    def __init__(self, access: Access, carry_out: Doer, welcome: str) -> None:
        self.access, self.welcome = access, welcome
        self.pages: set[Page] = set()
        self.frame = ""
        self.number = 0
        self._carry_out, self._waiting = carry_out, 0

    def show(self, frame: str) -> None:
        """Send a frame to the pages that wait for one; on the server's thread, as all of this class."""
        self.frame, self.number = frame, self.number + 1
        for page in tuple(self.pages):
            page.next_frame()

    async def do(self, asked: Asked) -> tuple[bool, str]:
        """Carry out what is asked in a thread of its own, which nothing waits for when the program ends."""
        stops = asked.get("do") == "stop"
        if not stops and self._waiting >= REQUESTS:
            return False, "not done: too many requests wait for the controller"
        loop = asyncio.get_running_loop()
        done: asyncio.Future[tuple[bool, str]] = loop.create_future()

        def give(result: tuple[bool, str]) -> None:
            if not done.done():
                done.set_result(result)

        def work() -> None:
            result = False, "not done: the dashboard failed, see its output"
            try:
                result = self._carry_out(asked)
            finally:
                loop.call_soon_threadsafe(give, result)

        self._waiting += not stops
        try:
            threading.Thread(target=work, daemon=True, name="request").start()
            return await done
        finally:
            self._waiting -= not stops


class Guarded(RequestHandler):
    """A handler that refuses a foreign Host, and sets the headers that keep other pages out."""

    def initialize(self, hub: Hub) -> None:
        self.hub = hub

    def set_default_headers(self) -> None:
        for name, value in HEADERS.items():
            self.set_header(name, value)
        self.clear_header("Server")

    def prepare(self) -> None:
        if objection := self.hub.access.objection(self.request.headers.get("Host")):
            raise HTTPError(403, reason=objection)

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        self.set_header("Content-Type", "text/plain; charset=utf-8")
        self.finish(f"tendond: {self._reason}\n")


class File(Guarded):
    """A file of the page. It holds no data, so it needs no token."""

    def get(self, name: str) -> None:
        """Send it."""
        if name not in FILES:
            raise HTTPError(404)
        file, kind = FILES[name]
        self.set_header("Content-Type", f"{kind}; charset=utf-8")
        self.finish((PAGE / file).read_bytes())


class Stop(Guarded):
    """A stop beside the WebSocket, for a page whose WebSocket hangs."""

    async def post(self) -> None:
        """Stop, and send the reply."""
        headers = self.request.headers
        if not Access.is_own(headers.get("Origin"), headers.get("Host")):
            raise HTTPError(403, reason="this is another page's")
        if not self.hub.access.admits(headers.get("Authorization", "").removeprefix("Bearer").strip()):
            raise HTTPError(401, reason="the token is missing or wrong")
        done, message = await self.hub.do({"do": "stop"})
        self.set_header("Content-Type", "application/json")
        self.finish(json.dumps({"done": done, "message": message}))


class Page(Guarded, WebSocketHandler):
    """A page's WebSocket."""

    def initialize(self, hub: Hub) -> None:
        super().initialize(hub)
        self._known = False
        self._sent = self._confirmed = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self._timeout: asyncio.TimerHandle | None = None

    def check_origin(self, origin: str) -> bool:
        """Refuse every other page, and a program that names none."""
        return Access.is_own(origin, self.request.headers.get("Host"))

    def prepare(self) -> None:
        super().prepare()
        if not Access.is_own(self.request.headers.get("Origin"), self.request.headers.get("Host")):
            raise HTTPError(403, reason="this is another page's")
        if len(self.hub.pages) >= PAGES:
            raise HTTPError(503, reason=f"{PAGES} pages are open already")

    def open(self, *args: str, **kwargs: str) -> None:
        """Wait for the token."""
        self.set_nodelay(True)
        self._timeout = asyncio.get_running_loop().call_later(TOKEN_SECONDS, self._time_out)

    def on_message(self, message: str | bytes) -> None:
        """Take the token, a confirmation, or a request; never wait, or the next one would."""
        try:
            asked = json.loads(message)
        except ValueError:
            asked = None
        if not isinstance(asked, dict):
            self.close(1003, "no JSON object")
        elif not self._known:
            self._greet(asked.get("token"))
        elif "seen" in asked:
            self._confirmed = self._sent
            self.next_frame()
        else:
            task = asyncio.get_running_loop().create_task(self._reply(asked))
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

    def on_close(self) -> None:
        """Forget the page."""
        self.hub.pages.discard(self)

    def next_frame(self) -> None:
        """Send the newest frame, if the page has confirmed the last one and there is a newer."""
        if self._confirmed == self._sent and self._sent != self.hub.number:
            self._sent = self.hub.number
            self._put(self.hub.frame)

    def _greet(self, token: object) -> None:
        if not self.hub.access.admits(token):
            self.close(4401, "the token is missing or wrong")
            return
        self._known = True
        self.hub.pages.add(self)
        self._put(self.hub.welcome)
        self.next_frame()

    def _time_out(self) -> None:
        if not self._known:
            self.close(4401, "no token came")

    async def _reply(self, asked: Asked) -> None:
        done, message = await self.hub.do(asked)
        self._put(json.dumps({"reply": asked.get("id"), "done": done, "message": message}))

    def _put(self, text: str) -> None:
        try:
            future = asyncio.ensure_future(self.write_message(text))
        except (WebSocketClosedError, StreamClosedError):
            return
        future.add_done_callback(lambda one: one.cancelled() or one.exception())  # a page that is gone is no error


def serve(hub: Hub, host: str, port: int) -> tuple[HTTPServer, int]:
    """Listen; return the server and its port.

    Raises:
        OSError: the address cannot be used.
    """

    def quiet(handler: RequestHandler) -> None:
        """Write no line for each request."""

    routes: list[Any] = [
        (r"/live", Page, {"hub": hub}),
        (r"/stop", Stop, {"hub": hub}),
        (r"/([a-z.]*)", File, {"hub": hub}),
    ]
    application = Application(
        routes, log_function=quiet, websocket_max_message_size=LARGEST_MESSAGE, websocket_ping_interval=5.0
    )
    sockets = bind_sockets(port, host)
    server = HTTPServer(application, max_body_size=LARGEST_MESSAGE)
    server.add_sockets(sockets)
    return server, int(sockets[0].getsockname()[1])
