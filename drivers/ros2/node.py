"""A node of ROS 2 on a Zenoh session, without ROS: its publishers, subscriptions and services, as rmw_zenoh has them.

Sources: rmw_zenoh's design document (see `names`), and for what it leaves open, rmw_zenoh_cpp/src/detail: publishers
and their caches (rmw_publisher_data.cpp), replies (rmw_service_data.cpp).
"""

import json
import time
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from typing import Any

import zenoh

from tendond import TendondError
from tendond.bus.client import RETRY_SECONDS, StoppedError
from tendond.drivers.ros2.names import Attachment, Kind, NodeName, Qos, gid_of, topic_key
from tendond.drivers.ros2.topics import Topic
from tendond.drivers.ros2.types import Types

CDR = "application/cdr"
UNKNOWN = Attachment(0, 0, bytes(16))


class RouterError(TendondError):
    """Error of a Zenoh router of ROS 2 that cannot be reached."""


class Publisher:
    """A publisher of ROS 2.

    Args:
        put: of a Zenoh publisher.
        types: of the distribution.
        gid: its identity.
    """

    def __init__(self, put: Callable[..., Any], types: Types, gid: bytes) -> None:
        self._put, self._types, self._gid = put, types, gid
        self.count = 0

    def publish(self, message: Any) -> None:
        """Publish a message of the publisher's type; while the router is gone, it is lost."""
        self.count += 1
        attachment = Attachment(self.count, time.time_ns(), self._gid)
        with suppress(zenoh.ZError):
            self._put(self._types.encode(message), attachment=attachment.encode())


class Call:
    """A request to a service, which is replied to once.

    Attributes:
        payload: of the request, CDR.
        attachment: what the client sent with it; none if that is not rmw_zenoh's.
        arrived: monotonic time of its arrival [s].
    """

    def __init__(self, query: zenoh.Query, types: Types) -> None:
        self._query, self._types = query, types
        self.arrived = time.monotonic()
        self.payload = b"" if query.payload is None else query.payload.to_bytes()
        self.attachment = _attachment(query.attachment)

    def reply(self, response: Any) -> None:
        """Send the response; a client that has left does not matter."""
        asked = self.attachment or UNKNOWN
        attachment = Attachment(asked.sequence, time.time_ns(), asked.gid)
        with suppress(zenoh.ZError):
            payload = self._types.encode(response)
            self._query.reply(self._query.key_expr, payload, encoding=CDR, attachment=attachment.encode())
        self._query.drop()


class Node:
    """A node, from now until its session is closed.

    Args:
        session: of Zenoh, to a router of ROS 2.
        types: of the distribution.
        domain: ROS_DOMAIN_ID.
        namespace: with a leading slash. name: without one.
    """

    def __init__(self, session: zenoh.Session, types: Types, domain: int, namespace: str, name: str) -> None:
        self._session, self._types = session, types
        self._name = NodeName(domain, str(session.info.zid()), namespace, name)
        self._numbers = count(1)
        self._kept: list[Any] = [session.liveliness().declare_token(self._name.token())]

    def publisher(self, topic: Topic) -> Publisher:
        """Declare a publisher."""
        key, token = self._declare(Kind.PUBLISHER, topic.name, topic.type_name, topic.qos)
        declared: Any
        if topic.qos.latched:
            declared = zenoh.ext.declare_advanced_publisher(
                self._session,
                key,
                encoding=CDR,
                cache=zenoh.ext.CacheConfig(max_samples=topic.qos.depth),
                publisher_detection=True,
            )
        else:
            declared = self._session.declare_publisher(key, encoding=CDR, express=True)
        self._kept.append(declared)
        return Publisher(declared.put, self._types, gid_of(token))

    def subscribe(self, topic: Topic, receive: Callable[[bytes, Attachment | None], None]) -> None:
        """Pass on each message, with what its publisher sent with it, on Zenoh's thread."""
        key, _ = self._declare(Kind.SUBSCRIPTION, topic.name, topic.type_name, topic.qos)

        def arrived(sample: zenoh.Sample) -> None:
            if sample.kind == zenoh.SampleKind.PUT:
                receive(sample.payload.to_bytes(), _attachment(sample.attachment))

        self._kept.append(self._session.declare_subscriber(key, arrived))

    def serve(self, service: str, type_name: str, receive: Callable[[Call], None]) -> None:
        """Pass on each call of a service, on Zenoh's thread.

        Args:
            service: its name, with namespace.
            type_name: as ROS has it.
            receive: has to see to a reply.
        """
        key, _ = self._declare(Kind.SERVICE, service, type_name, Qos())
        # complete, since clients ask for ALL_COMPLETE
        queryable = self._session.declare_queryable(key, lambda query: receive(Call(query, self._types)), complete=True)
        self._kept.append(queryable)

    def _declare(self, kind: Kind, name: str, type_name: str, qos: Qos) -> tuple[str, str]:
        """Declare the token of an entity; return its key and the token."""
        type_hash = self._types.hash_of(type_name)
        token = self._name.entity_token(next(self._numbers), kind, name, type_name, type_hash, qos)
        self._kept.append(self._session.liveliness().declare_token(token))
        return topic_key(self._name.domain, name, type_name, type_hash), token


def open_router(endpoint: str, timeout: float, stopped: Callable[[], bool] = lambda: False) -> zenoh.Session:
    """Open a client session of a router of ROS 2, trying again until it is there.

    Args:
        endpoint: of the router.
        timeout: time to keep trying [s].
        stopped: called between two tries; true gives up.

    Raises:
        StoppedError: `stopped` returned true.
        RouterError: the router did not appear in time.
    """
    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    config.insert_json5("timestamping/enabled", "true")  # the cache of a latched topic is sorted by them
    deadline = time.monotonic() + timeout
    while True:
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            if stopped():
                raise StoppedError from error
            if time.monotonic() > deadline:
                raise RouterError(
                    f"no Zenoh router at {endpoint}: start it with 'ros2 run rmw_zenoh_cpp rmw_zenohd', "
                    "or name another with --router"
                ) from error
        time.sleep(RETRY_SECONDS)


def _attachment(data: zenoh.ZBytes | None) -> Attachment | None:
    try:
        return None if data is None else Attachment.decode(data.to_bytes())
    except ValueError:
        return None
