"""The tools that people use: mcap's own checks, Rerun, Foxglove's protocol, the example of the Python API."""

import base64
import json
import os
import re
import shutil
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.recording import scene
from tendond.offline.logs.log import load
from tendond.offline.logs.paths import TipPath
from tendond.offline.logs.run import open_run
from tendond.offline.replay.offline import record_lockstep
from tendond.schemas.config.rig import check_config
from tendond.schemas.requests import ControlAction
from tests.golden.scripts import FOLDER

ROOT = Path(__file__).parents[3]
NORMAL = FOLDER / "normal.mcap"
RERUN = shutil.which("rerun", path=f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}")


def test_the_file_passes_the_mcap_librarys_own_checks() -> None:
    with NORMAL.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        messages = list(reader.iter_messages())
        assert len(messages) == summary.statistics.message_count
        assert {schema.name for schema, _, _ in messages if schema is not None} >= {
            *("foxglove.PoseInFrame", "foxglove.FrameTransforms", "foxglove.SceneUpdate", "tendond.CycleRecord")
        }
        for _, channel, message in messages:
            if channel.topic == "tf":
                frames = {frame["child_frame_id"] for frame in json.loads(message.data)["transforms"]}
                assert frames <= {"tip_model", "tip_measured"}
        scene = next(json.loads(message.data) for _, channel, message in messages if channel.topic == "rod/shape")
        assert len(scene["entities"][0]["lines"]) == 1 + 4  # rod and tendons


def test_the_scene_has_a_target_and_a_trail_of_the_tip_that_does_not_grow_for_ever(tmp_path: Path) -> None:
    """A log in space: lockstep writes a push out of the plane."""
    impact = {"time": 0.6, "duration": 0.05, "force": (0.0, 2.0, 0.0)}
    tables = {"simulator": {"impacts": [impact]}, "log": {"shape_period": 2}, "commissioning": {"probe": False}}
    config = check_config(tables, "test")
    path = tmp_path / "space.mcap"
    setup = CycleSetup.from_config(config)
    records = record_lockstep(setup, 160, {5: ControlAction.ARM}, path)
    scenes = [json.loads(message.data)["entities"] for _, message in open_run(path).messages(("rod/shape",))]
    trails = [[tuple(point.values()) for point in trail["lines"][0]["points"]] for _, trail in scenes]
    assert [len(trail) for trail in trails] == [min(i + 1, scene.TRAIL_POINTS) for i in range(len(trails))]
    measured = [record.measured or record.model.position for record in records[::2]]
    np.testing.assert_allclose(trails[-1], measured[-scene.TRAIL_POINTS :], atol=0.6e-4)
    assert max(abs(point[1]) for point in trails[-1]) > 0.02
    for (rod, trail), record in zip(scenes, records[::2], strict=True):
        assert (rod["id"], trail["id"]) == ("rod", "trail")
        assert tuple(rod["spheres"][1]["pose"]["position"].values()) == record.reference.position
    assert TipPath.of(load(path)).view == (22.0, -55.0)


def test_tendons_run_at_their_distance_from_the_backbone() -> None:
    points = np.linspace((0.0, 0.0, 0.0), (0.0, 0.0, 0.5), 50)
    (path,) = scene.tendon_paths(np.tile(np.eye(3), (6, 1, 1)), points, [(0.02, 0.0)])
    np.testing.assert_allclose(path[:, 0], 0.02)
    np.testing.assert_allclose(path[[0, -1], 2], [0.0, 0.5])


@pytest.mark.skipif(RERUN is None, reason="needs rerun-sdk")
def test_rerun_finds_nothing_wrong_with_a_log_and_loads_it(tmp_path: Path) -> None:
    assert RERUN is not None
    environment = {**os.environ, "HOME": str(tmp_path), "NO_COLOR": "1"}
    check = subprocess.run(
        [RERUN, "mcap", "check", str(NORMAL)], capture_output=True, text=True, timeout=60, env=environment
    )
    assert check.returncode == 0, check.stderr
    rows = re.findall(r"^(\S+)\s+\d+\s+\d+\s+(\S+)", check.stdout, re.MULTILINE)
    assert {topic for status, topic in rows if status == "ok"} >= {"cycle", "rod/shape", "tip/model", "tf"}
    assert all(status == "ok" for status, _ in rows)
    out = tmp_path / "log.rrd"
    subprocess.run(
        [RERUN, "mcap", "convert", str(NORMAL), "-o", str(out)], capture_output=True, timeout=60, check=True,
        env=environment,
    )  # fmt: skip
    assert out.stat().st_size > 10_000


@pytest.mark.skipif(RERUN is None, reason="needs rerun-sdk")
def test_the_rerun_recipe_makes_curves_and_shapes(tmp_path: Path) -> None:
    assert RERUN is not None
    out = tmp_path / "run.rrd"
    environment = {**os.environ, "HOME": str(tmp_path), "NO_COLOR": "1"}
    recipe = [sys.executable, str(ROOT / "deploy" / "rerun" / "log_to_rerun.py"), str(NORMAL), "--save", str(out)]
    subprocess.run(recipe, capture_output=True, timeout=60, check=True, env=environment)
    stats = subprocess.run(
        [RERUN, "rrd", "stats", str(out)], capture_output=True, text=True, timeout=60, check=True, env=environment
    )
    for entity in (
        "/rod",
        "/tendons",
        "/tip",
        "/trail",
        "/reference",
        "/target",
        "/numbers/command/displacement/0",
        "/numbers/model/residual",
    ):
        assert f"{entity}:" in stats.stdout, entity


def test_the_example_runs() -> None:
    example = [sys.executable, str(ROOT / "examples" / "analyse_log.py"), str(NORMAL)]
    result = subprocess.run(example, capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr
    assert "command.displacement: shape (190, 4), unit m" in result.stdout


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

    def subscribe(self, channel: int) -> None:
        """Subscribe to a channel, as subscription 7."""
        text = json.dumps({"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel}]}).encode()
        mask = os.urandom(4)
        masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(text))
        self._socket.sendall(bytes([0x81, 0x80 | len(text)]) + mask + masked)

    def message(self) -> dict[str, Any]:
        """The next message on it."""
        while True:
            opcode, payload = self.receive()
            if opcode == 2 and payload[0] == 1 and struct.unpack("<I", payload[1:5])[0] == 7:
                return dict(json.loads(payload[13:]))

    def close(self) -> None:
        self._socket.close()


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
