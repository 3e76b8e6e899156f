"""The page's server with real HTTP and WebSockets on loopback, and a stand-in for what carries requests out."""

import asyncio
import json
import threading
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from tornado.httpclient import AsyncHTTPClient, HTTPClientError, HTTPRequest, HTTPResponse
from tornado.websocket import WebSocketClientConnection, websocket_connect

from tendond.cli.dashboard.access import Access
from tendond.cli.dashboard.files import FILES
from tendond.cli.dashboard.server import REQUESTS, Hub, serve

TOKEN = "not-to-be-guessed"
FOREIGN = [
    {"Origin": "http://evil.example"},
    {"Origin": "null"},
    {},
    {"Host": "evil.example", "Origin": "http://evil.example"},
]
"""Headers of other pages, of a program that names none, and of a name that was made to resolve to this computer."""


class Bench:
    """A server; what it was asked to do is in `asked`, and all but stops wait for `go`."""

    def __init__(self, access: Access) -> None:
        self.asked: list[dict[str, Any]] = []
        self.go = threading.Event()
        self.pages: list[WebSocketClientConnection] = []
        self.hub = Hub(access, self.carry_out, '{"welcome": {}}')
        self.server, self.port = serve(self.hub, "127.0.0.1", 0)
        self.own = {"Origin": f"http://127.0.0.1:{self.port}"}

    def carry_out(self, asked: dict[str, Any]) -> tuple[bool, str]:
        self.asked.append(asked)
        if asked.get("do") != "stop":
            self.go.wait(30.0)
        return True, f"done: {asked.get('do')}"

    async def http(self, path: str, **request: Any) -> HTTPResponse:
        return await AsyncHTTPClient().fetch(f"http://127.0.0.1:{self.port}/{path}", **request, raise_error=False)

    async def page(self, headers: dict[str, str], token: str = "") -> WebSocketClientConnection:
        wanted = HTTPRequest(f"ws://127.0.0.1:{self.port}/live", headers=headers)
        page = await websocket_connect(wanted)
        self.pages.append(page)
        await page.write_message(json.dumps({"token": token}))
        return page


def with_server(test: Callable[[Bench], Awaitable[None]], access: Access | None = None) -> None:
    async def run() -> None:
        bench = Bench(access or Access(loopback=True))
        try:
            await asyncio.wait_for(test(bench), 30.0)
        finally:
            bench.go.set()
            for page in bench.pages:
                page.close()
            bench.server.stop()
            await bench.server.close_all_connections()

    asyncio.run(run())


async def next_of(page: WebSocketClientConnection) -> Any:
    text = await page.read_message()
    return None if text is None else json.loads(text)


@pytest.mark.parametrize("headers", FOREIGN)
def test_another_page_gets_no_websocket_and_cannot_stop(headers: dict[str, str]) -> None:
    async def test(bench: Bench) -> None:
        with pytest.raises(HTTPClientError) as refused:
            await bench.page(headers)
        assert refused.value.code == 403
        reply = await bench.http("stop", method="POST", body="{}", headers=headers)
        assert reply.code == 403
        assert reply.body.startswith(b"tendond: ")
        assert not bench.asked
        assert not bench.hub.pages

    with_server(test)


def test_its_own_page_stops_by_http() -> None:
    async def test(bench: Bench) -> None:
        reply = await bench.http("stop", method="POST", body="", headers=bench.own)
        assert json.loads(reply.body) == {"done": True, "message": "done: stop"}
        assert (await bench.http("stop", headers=bench.own)).code == 405

    with_server(test)


def test_nothing_is_sent_and_nothing_is_done_without_the_token() -> None:
    async def test(bench: Bench) -> None:
        bench.hub.show('{"now": 1}')
        for token in ("", TOKEN[:-1], TOKEN + "x"):
            page = await bench.page(bench.own, token)
            await page.write_message('{"do": "stop"}')
            assert await next_of(page) is None
            assert page.close_code == 4401
            headers = {**bench.own, "Authorization": f"Bearer {token}"}
            assert (await bench.http("stop", method="POST", body="", headers=headers)).code == 401
        assert not bench.asked
        page = await bench.page(bench.own, TOKEN)
        assert await next_of(page) == {"welcome": {}}
        assert await next_of(page) == {"now": 1}
        headers = {**bench.own, "Authorization": f"Bearer {TOKEN}"}
        assert (await bench.http("stop", method="POST", body="", headers=headers)).code == 200

    with_server(test, Access(loopback=True, token=TOKEN))


def test_the_files_of_the_page_and_no_others_are_sent_with_headers_that_keep_other_pages_out() -> None:
    async def test(bench: Bench) -> None:
        for name in FILES:
            reply = await bench.http(name)
            assert reply.code == 200
            assert reply.headers["X-Frame-Options"] == "DENY"
            assert "default-src 'none'" in reply.headers["Content-Security-Policy"]
            assert reply.headers["Cache-Control"] == "no-store"
            text = reply.body.decode()
            assert "http://" not in text
            assert "https://" not in text
        for name in ("page", "server.py", "../server.py", "%2e%2e/server.py", "..%2fserver.py", "etc/passwd"):
            assert (await bench.http(name)).code == 404
        assert (await bench.http("", headers={"Host": "evil.example"})).code == 403

    with_server(test)


def test_a_stop_is_carried_out_while_as_many_requests_as_are_taken_hang() -> None:
    async def test(bench: Bench) -> None:
        page = await bench.page(bench.own)
        await next_of(page)
        for number in range(REQUESTS + 1):
            await page.write_message(json.dumps({"do": "arm", "id": number}))
        refused = await next_of(page)
        assert (refused["reply"], refused["done"]) == (REQUESTS, False)
        assert "too many requests" in refused["message"]
        await page.write_message('{"do": "stop", "id": "s"}')
        assert await next_of(page) == {"reply": "s", "done": True, "message": "done: stop"}
        reply = await bench.http("stop", method="POST", body="", headers=bench.own)
        assert json.loads(reply.body)["done"]
        assert [one["do"] for one in bench.asked].count("arm") == REQUESTS
        bench.go.set()
        assert {(await next_of(page))["reply"] for _ in range(REQUESTS)} == set(range(REQUESTS))

    with_server(test)


def test_a_page_that_does_not_confirm_a_frame_gets_the_newest_later_and_none_of_those_between() -> None:
    async def test(bench: Bench) -> None:
        page = await bench.page(bench.own)
        await next_of(page)
        for number in range(1, 50):
            bench.hub.show(json.dumps({"now": number}))
        assert await next_of(page) == {"now": 1}
        await page.write_message('{"seen": 1}')
        assert await next_of(page) == {"now": 49}

    with_server(test)


@pytest.mark.parametrize("text", ["", "[]", "{", "3", b"\xff\x00"])
def test_what_is_no_json_object_ends_the_connection(text: str | bytes) -> None:
    async def test(bench: Bench) -> None:
        page = await bench.page(bench.own)
        await next_of(page)
        await page.write_message(text, binary=isinstance(text, bytes))
        assert await next_of(page) is None
        assert not bench.asked

    with_server(test)
