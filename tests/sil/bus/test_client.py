"""The bus client: messages decoded and bounded, requests and their replies, on real Zenoh sessions."""

import json
import socket
import time
from collections.abc import Iterator

import pytest
import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.query import replies, reply_to_next
from tendond.bus.subscription import Subscription
from tendond.schemas.messages import TipPose
from tendond.schemas.requests import ControlReply
from tendond.schemas.wire import encode
from tests.rig.tracker import free_port

KEY = "paper/tip/pose"


@pytest.fixture(scope="module")
def sessions() -> Iterator[tuple[zenoh.Session, zenoh.Session]]:
    """Yield a hub and a client of it."""
    endpoint = f"tcp/127.0.0.1:{free_port(socket.SOCK_STREAM)}"
    config = zenoh.Config()
    config.insert_json5("listen/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as hub, open_client(endpoint, 5.0) as client:
        yield hub, client


def pose(seq: int) -> TipPose:
    return TipPose(
        seq=seq, stamp_ns=0, source="camera", valid=True, position=(0.0, 0.0, 0.5), orientation=(1.0, 0.0, 0.0, 0.0)
    )


def settled(hub: zenoh.Session, subscription: Subscription[TipPose]) -> None:
    """Wait until what the hub puts arrives at the subscription."""
    deadline = time.monotonic() + 5.0
    while subscription.newest() is None:
        assert time.monotonic() < deadline
        hub.put(KEY, encode(pose(0)))
        time.sleep(0.05)
    time.sleep(0.2)
    subscription.newest()


def test_a_subscription_keeps_the_last_messages_in_order(sessions: tuple[zenoh.Session, zenoh.Session]) -> None:
    hub, client = sessions
    poses = Subscription(client, KEY, TipPose, 3)
    settled(hub, poses)
    for seq in range(1, 6):
        hub.put(KEY, encode(pose(seq)))
    time.sleep(0.2)
    assert [one.seq for one in poses] == [3, 4, 5]
    assert list(poses) == []
    assert poses.newest() is None
    poses.close()


def test_what_cannot_be_decoded_is_counted_by_reason(sessions: tuple[zenoh.Session, zenoh.Session]) -> None:
    hub, client = sessions
    poses = Subscription(client, KEY, TipPose, 8)
    settled(hub, poses)
    hub.put(KEY, b"{")
    hub.delete(KEY)
    hub.put(KEY, encode(pose(7)))
    time.sleep(0.2)
    newest = poses.newest()
    assert newest is not None
    assert newest.seq == 7
    assert poses.unreadable == {"malformed": 1, "deleted": 1}
    poses.close()


def test_a_request_has_a_reply_and_a_foreign_one_is_refused(sessions: tuple[zenoh.Session, zenoh.Session]) -> None:
    hub, client = sessions
    asked: list[bytes | None] = []
    session_queryable = hub.declare_queryable("paper/servo/reset", lambda query: query.reply(query.key_expr, b"no"))
    with pytest.raises(BusError, match="the servo driver's reply is malformed: are both of the same version"):
        replies(client, "paper/servo/reset", b"reboot", 2.0, "servo driver")
    session_queryable.undeclare()
    queries = hub.declare_queryable("paper/servo/reset", zenoh.handlers.RingChannel(8))
    reply_to_next(queries, lambda payload: ControlReply(done=True, message=""))  # nothing waits: returns at once
    pending = client.get("paper/servo/reset", timeout=5.0)

    def reply_to(payload: bytes | None) -> ControlReply:
        asked.append(payload)
        return ControlReply(done=True, message="reset")

    deadline = time.monotonic() + 5.0
    while not asked and time.monotonic() < deadline:
        reply_to_next(queries, reply_to)
        time.sleep(0.01)
    assert asked == [None]
    assert [json.loads(reply.ok.payload.to_bytes())["message"] for reply in pending if reply.ok] == ["reset"]
    assert replies(client, "paper/no/such", None, 1.0, "servo driver") == []
