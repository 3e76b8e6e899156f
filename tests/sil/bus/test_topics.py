"""The list of what is on the bus, from which the documentation is made, is what really is on the bus."""

import time

import pytest
import zenoh

from tendond.schemas.topics import TOPICS
from tendond.schemas.wire import decode
from tests.sil.bus.live import Live
from tests.sil.rig import PATIENCE_SECONDS

pytestmark = pytest.mark.sil


def test_everything_on_the_bus_is_in_the_list(live: Live) -> None:
    published = {topic.name: topic.message for topic in TOPICS if topic.kind == "published"}
    del published["servo/health"]  # of the servo driver, which is not simulated here: tests/rig has it
    del published["sensor/*"]  # of which this rig has none: tests/sil/loop/test_sensors.py has some
    heard: set[str] = set()
    name, session = live.rig.name, live.session
    live.rig.arm(session)
    everything = session.declare_subscriber(f"{name}/**", zenoh.handlers.RingChannel(1000))
    deadline = time.monotonic() + PATIENCE_SECONDS
    while heard != set(published) and time.monotonic() < deadline:
        if (sample := everything.try_recv()) is None:
            time.sleep(0.01)
            continue
        topic = str(sample.key_expr).removeprefix(f"{name}/")
        kind = published[topic]  # nothing is said that is not in the list
        assert kind is not None
        decode(kind, sample.payload.to_bytes())
        heard.add(topic)
    everything.undeclare()
    tokens = [topic.name for topic in TOPICS if topic.kind == "token"]
    alive = session.liveliness().get(f"{name}/**", timeout=2.0)
    there = sorted(str(reply.ok.key_expr) for reply in alive if reply.ok)
    assert [token.partition("/controller-")[0] for token in there] == [
        f"{name}/{token.removesuffix('/*')}" for token in sorted(tokens)
    ]
    assert heard == set(published)
