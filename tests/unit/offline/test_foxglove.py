"""Foxglove: the layout's paths are in a real log, and its protocol plays one."""

import base64
import json
import os
import re
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from mcap.reader import make_reader

from tendond.offline.logs.run import open_run
from tests.golden.scripts import FOLDER

ROOT = Path(__file__).parents[3]
NORMAL = FOLDER / "normal.mcap"
DRAWN = {"foxglove.PoseInFrame", "foxglove.SceneUpdate", "foxglove.FrameTransforms"}
"""Topics of the 3D panel."""


PLOTTED = {"Plot": {"number", "integer", "boolean"}, "StateTransitions": {"string", "number", "integer", "boolean"}}
"""JSON types that a panel takes."""


def test_each_path_of_the_foxglove_layout_is_in_a_real_log_with_a_type_that_its_panel_takes() -> None:
    """Look a path up in the file's schemas, and in its messages where it has any on that topic."""
    with NORMAL.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        assert summary is not None
        schemas = {channel.topic: summary.schemas[channel.schema_id] for channel in summary.channels.values()}
        messages: dict[str, list[Any]] = {topic: [] for topic in schemas}
        for _, channel, message in reader.iter_messages():
            messages[channel.topic].append(json.loads(message.data))
    layout = json.loads((ROOT / "deploy" / "foxglove" / "layout.json").read_text())
    panels, checked = layout["configById"], 0
    for name, panel in panels.items():
        for path in panel.get("paths", []):
            topic, *steps = re.findall(r"[^.\[\]]+", path["value"])
            schema = json.loads(schemas[topic].data)
            found: list[Any] = messages[topic]
            for step in steps:
                schema = schema["items"] if step.isdecimal() else schema["properties"][step]
                found = [one[int(step) if step.isdecimal() else step] for one in found if one is not None]
            assert schema["type"] in PLOTTED[name.split("!")[0]], path
            kind = str if schema["type"] == "string" else (int, float)
            assert all(isinstance(one, kind) for one in found if one is not None), path
            assert not messages[topic] or any(one is not None for one in found), path
            checked += 1
        for topic in panel.get("topics", []):
            assert schemas[topic].name in DRAWN
        if "topicToRender" in panel:
            assert schemas[panel["topicToRender"]].name == "foxglove.Log"
    assert checked > 10

    def leaves(node: Any) -> list[str]:
        return [node] if isinstance(node, str) else leaves(node["first"]) + leaves(node["second"])

    assert sorted(leaves(layout["layout"])) == sorted(panels)


class FoxgloveClient:
    """WebSocket client with the parts that a test needs: the upgrade, text and binary frames, no fragments."""

    def __init__(self, port: int) -> None:
        self._socket = socket.create_connection(("127.0.0.1", port), timeout=30.0)
        key = base64.b64encode(os.urandom(16)).decode()
        self._socket.sendall(
            f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n".encode()
        )
        head = b""
        while not head.endswith(b"\r\n\r\n"):
            head += self._socket.recv(1)
        assert b" 101 " in head.split(b"\r\n")[0], head

    def _exactly(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            more = self._socket.recv(count - len(data))
            assert more
            data += more
        return data

    def receive(self) -> tuple[int, bytes]:
        """Opcode and payload of the next frame."""
        first, length = self._exactly(2)
        if length == 126:
            (length,) = struct.unpack(">H", self._exactly(2))
        elif length == 127:
            (length,) = struct.unpack(">Q", self._exactly(8))
        return first & 0x0F, self._exactly(length)

    def advertised(self) -> dict[str, dict[str, Any]]:
        """The server's channels, by topic."""
        while True:
            opcode, payload = self.receive()
            if opcode == 1 and (message := json.loads(payload))["op"] == "advertise":
                return {channel["topic"]: channel for channel in message["channels"]}

    def _send(self, opcode: int, payload: bytes) -> None:
        """Send a frame of less than 126 bytes, masked as a client's must be."""
        mask = os.urandom(4)
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))
        self._socket.sendall(bytes([0x80 | opcode, 0x80 | len(payload)]) + mask + masked)

    def subscribe(self, channel: int) -> None:
        """Subscribe to a channel, as subscription 7."""
        self._send(1, json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel}]}).encode())

    def server_info(self) -> dict[str, Any]:
        """What the server can do: the first message on a connection."""
        while True:
            opcode, payload = self.receive()
            if opcode == 1 and (message := json.loads(payload))["op"] == "serverInfo":
                return dict(message)

    def control(self, play: bool, speed: float = 1.0, seek_ns: int | None = None) -> "PlaybackState":
        """Send a request to control the playback; return the reply to it."""
        name = os.urandom(4).hex().encode()
        jump = struct.pack("<BQ", seek_ns is not None, seek_ns or 0)
        self._send(2, struct.pack("<BBf", 3, not play, speed) + jump + struct.pack("<I", len(name)) + name)
        while (state := self.playback_state()).request != name.decode():
            pass
        return state

    def playback_state(self) -> "PlaybackState":
        """The next state that the server tells."""
        while True:
            opcode, payload = self.receive()
            if opcode == 2 and payload[0] == 5:
                status, now_ns, speed, jumped, length = struct.unpack("<BQfBI", payload[1:19])
                return PlaybackState(status, now_ns, speed, bool(jumped), payload[19 : 19 + length].decode())

    def message(self) -> dict[str, Any]:
        """The next message on it."""
        while True:
            opcode, payload = self.receive()
            if opcode == 2 and payload[0] == 1 and struct.unpack("<I", payload[1:5])[0] == 7:
                return dict(json.loads(payload[13:]))

    def close(self) -> None:
        self._socket.close()


PLAYING, PAUSED, ENDED = 0, 1, 3


class PlaybackState(NamedTuple):
    """State of the playback: status, time of the log [ns], speed, whether it jumped, name of the request replied to."""

    status: int
    now_ns: int
    speed: float
    jumped: bool
    request: str


@contextmanager
def viewing(*arguments: str) -> Iterator[FoxgloveClient]:
    """`tendond log view` and a client of it."""
    process = subprocess.Popen(
        [sys.executable, "-m", "tendond.cli", "log", "view", *arguments, "--port", "0"],
        stderr=subprocess.PIPE,
        text=True,
    )
    client = None
    try:
        assert process.stderr is not None
        for line in process.stderr:
            if found := re.search(r"at ws://127.0.0.1:(\d+)", line):
                break
        else:
            raise AssertionError("it never served")
        client = FoxgloveClient(int(found[1]))
        yield client
    finally:
        if client is not None:
            client.close()
        process.terminate()
        _, said = process.communicate(timeout=30)
    assert process.returncode == 0, said
    assert "Traceback" not in said


def test_view_plays_a_log_to_foxglove() -> None:
    pytest.importorskip("foxglove")
    with viewing(str(NORMAL)) as client:
        channels = client.advertised()
        assert channels["rod/shape"]["schemaName"] == "foxglove.SceneUpdate"
        assert channels["cycle"]["encoding"] == "json"
        client.subscribe(channels["cycle"]["id"])
        first, second = client.message(), client.message()
        assert second["tick"] == first["tick"] + 1


def cycles(first: int, last: int) -> tuple[int, int]:
    """Log times of two cycles of the log [ns]."""
    with NORMAL.open("rb") as stream:
        times = [message.log_time for _, _, message in make_reader(stream).iter_messages(["cycle"])]
    return times[first], times[last]


def test_a_viewer_holds_jumps_and_changes_the_speed_of_a_log() -> None:
    pytest.importorskip("foxglove")
    middle_ns, later_ns = cycles(60, 150)
    with viewing(str(NORMAL)) as client:
        info = client.server_info()
        assert {"playbackControl", "time"} <= set(info["capabilities"])
        channels = client.advertised()
        client.subscribe(channels["cycle"]["id"])
        held = client.control(play=False)
        assert (held.status, held.jumped) == (PAUSED, False)
        assert client.control(play=False).now_ns == held.now_ns

        jumped = client.control(play=False, seek_ns=middle_ns)
        assert jumped == (PAUSED, middle_ns, 1.0, True, jumped.request)
        while client.message()["tick"] != 60:  # shown though it stands still; before it, what was sent before the jump
            pass
        assert client.control(play=False).now_ns == middle_ns

        assert client.control(play=True, speed=4.0)[:3:2] == (PLAYING, 4.0)
        assert [client.message()["tick"] for _ in range(5)] == [61, 62, 63, 64, 65]
        assert client.control(play=True, speed=100.0, seek_ns=later_ns).now_ns == later_ns
        assert [client.message()["tick"] for _ in range(3)][-1] > 149
        assert client.playback_state()[:1] == (ENDED,)
        assert client.control(play=True, speed=1.0).status == PLAYING  # from the start again
        while client.message()["tick"] > 5:
            pass


def test_a_jump_passes_over_what_lies_before_it() -> None:
    """Chunks that end before it are not unpacked, and the file's summary names the channels that they define."""
    run = open_run(NORMAL)
    whole = [(topic, message) for topic, message in run.messages(("cycle", "rod/shape"))]
    start_ns = whole[len(whole) // 2][1].log_time
    late = list(run.messages(("cycle", "rod/shape"), start_ns))
    assert late == whole[-len(late) :]
    assert {topic for topic, _ in late} == {"cycle", "rod/shape"}
    assert len(late) < len(whole)
    assert sum(message.log_time >= start_ns for _, message in whole) <= len(late)
