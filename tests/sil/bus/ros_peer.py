"""A node of ROS 2 as rmw_zenoh makes one, written from its design document alone: it shares no code with the bridge.

Type hashes are literals: those of messages as `ros2 topic info -v` of Jazzy prints them, that of Trigger as public
clients of rmw_zenoh have it. Messages are read by rosbags, attachments by Zenoh's own deserialiser.
"""

import json
import socket
import time
from collections.abc import Callable
from typing import Any

import zenoh
from rosbags.typesys import Stores, get_typestore

HASHES = {
    "geometry_msgs/msg/PoseStamped": "10f3786d7d40fd2b54367835614bff85d4ad3b5dab62bf8bca0cc232d73b4cd8",
    "geometry_msgs/msg/PointStamped": "4c0296af86e01e562e9e0405d138a01537247580076c58ea38d7923ac1045897",
    "geometry_msgs/msg/PoseWithCovarianceStamped": "26432f9803e43727d3c8f668d1fdb3c630f548af631e2f4e31382371bfea3b6e",
    "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    "diagnostic_msgs/msg/DiagnosticArray": "5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e",
    "tf2_msgs/msg/TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "visualization_msgs/msg/MarkerArray": "86cb8800b6fb05b5eff1abd7a56f62a5641d3ae9a1c29e78e67e704f1d067dcf",
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "std_srvs/srv/Trigger": "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f",
}
PATIENCE_SECONDS = 60.0
TRIGGER_REQUEST = b"\x00\x01\x00\x00\x00"
GID = bytes(range(16))
Received = tuple[Any, tuple[int, int, bytes]]
"""A message, and sequence number, wall-clock time [ns] and publisher that came with it."""


def free_endpoint() -> str:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


def opened(mode: str, *, listen: str = "", connect: str = "") -> zenoh.Session:
    """Open a session as rmw_zenoh configures its own: without multicast, with timestamps."""
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("timestamping/enabled", "true")
    config.insert_json5("listen/endpoints", json.dumps([listen or "tcp/127.0.0.1:0"]))
    if connect:
        config.insert_json5("connect/endpoints", json.dumps([connect]))
    return zenoh.open(config)


class RosPeer:
    """A node in a domain, connected to a router as a peer."""

    def __init__(self, router: str, domain: int) -> None:
        self.session = opened("peer", connect=router)
        self.domain = domain
        self.store = get_typestore(Stores.ROS2_JAZZY)
        self._sequence = 0
        self._kept: list[Any] = []

    def key(self, name: str, kind: str) -> str:
        package, group, short = kind.split("/")
        return f"{self.domain}/{name.lstrip('/')}/{package}::{group}::dds_::{short}_/RIHS01_{HASHES[kind]}"

    def tokens(self) -> set[str]:
        """Everything in the graph, without the identities of sessions."""
        found = self.session.liveliness().get(f"@ros2_lv/{self.domain}/**", timeout=5.0)
        parts = [str(reply.ok.key_expr).split("/") for reply in found if reply.ok is not None]
        return {"/".join(part[5:]) for part in parts}

    def echo(self, topic: str, kind: str, *, latched: bool = False) -> list[Received]:
        """Subscribe, as `ros2 topic echo` does; the list grows as messages come."""
        heard: list[Received] = []

        def arrived(sample: zenoh.Sample) -> None:
            assert sample.attachment is not None
            head = zenoh.ext.z_deserialize(tuple[zenoh.ext.Int64, zenoh.ext.Int64, bytes], sample.attachment)
            heard.append((self.store.deserialize_cdr(sample.payload.to_bytes(), kind), head))

        if latched:
            history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=1)
            key = self.key(topic, kind)
            self._kept.append(zenoh.ext.declare_advanced_subscriber(self.session, key, arrived, history=history))
        else:
            self._kept.append(self.session.declare_subscriber(self.key(topic, kind), arrived))
        return heard

    def attachment(self, age: float = 0.0) -> zenoh.ZBytes:
        self._sequence += 1
        stamp = time.time_ns() - round(1e9 * age)
        return zenoh.ext.z_serialize((zenoh.ext.Int64(self._sequence), zenoh.ext.Int64(stamp), GID))

    def publish(self, topic: str, kind: str, payload: bytes) -> None:
        self.session.put(self.key(topic, kind), payload, attachment=self.attachment())

    def call(self, service: str, payload: bytes = TRIGGER_REQUEST, age: float = 0.0) -> tuple[bool, str]:
        """Call a Trigger, as rmw_zenoh's clients do; check that the reply is to this call."""
        attachment = self.attachment(age)
        sequence = self._sequence
        replies = self.session.get(
            self.key(service, "std_srvs/srv/Trigger"),
            payload=payload,
            attachment=attachment,
            target=zenoh.QueryTarget.ALL_COMPLETE,
            consolidation=zenoh.ConsolidationMode.NONE,
            timeout=PATIENCE_SECONDS,
        )
        (reply,) = replies
        sample = reply.ok
        assert sample is not None
        assert sample.attachment is not None
        head = zenoh.ext.z_deserialize(tuple[zenoh.ext.Int64, zenoh.ext.Int64, bytes], sample.attachment)
        assert (head[0], head[2]) == (sequence, GID)
        data = sample.payload.to_bytes()
        assert data[:4] == b"\x00\x01\x00\x00"
        size = int.from_bytes(data[8:12], "little")
        assert data[12 + size - 1] == 0
        return bool(data[4]), data[12 : 12 + size - 1].decode()


def until(wanted: Callable[[], Any]) -> Any:
    """Wait for something that is true; return it."""
    deadline = time.monotonic() + PATIENCE_SECONDS
    while not (found := wanted()):
        assert time.monotonic() < deadline
        time.sleep(0.02)
    return found
