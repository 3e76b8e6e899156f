"""Names of ROS 2's nodes, topics and services as key expressions and liveliness tokens on Zenoh.

Source: rmw_zenoh's design document (https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md), sections "Topic and
Service name mapping" and "Graph Cache", and where that refers to code, `qos_to_keyexpr` in
rmw_zenoh_cpp/src/detail/liveliness_utils.cpp.
"""

import hashlib
import re
import struct
from dataclasses import dataclass
from enum import StrEnum

ADMIN_SPACE = "@ros2_lv"
GID_SIZE = 16
_HEAD = struct.Struct("<qqB")


class Kind(StrEnum):
    """Kind of an entity in the graph of ROS, as its token has it."""

    NODE = "NN"
    PUBLISHER = "MP"
    SUBSCRIPTION = "MS"
    SERVICE = "SS"


@dataclass(frozen=True)
class Qos:
    """Quality of service, as far as the bridge uses it: reliable, the newest `depth` messages.

    Attributes:
        depth: of the history.
        latched: durability 'transient local': who comes late receives what was published last.
    """

    depth: int = 10
    latched: bool = False

    def __str__(self) -> str:
        """Form in a token: reliability, durability, history, deadline, lifespan, liveliness; empty: the default."""
        return f":{1 if self.latched else ''}:,{self.depth}:,:,:,,"


def ros_name(rig: str) -> str:
    """Return a rig's name as ROS 2 allows it: letters, digits and underscores, beginning with no digit."""
    name = re.sub(r"_{2,}", "_", rig.replace("-", "_")).rstrip("_") or "rig"
    return f"rig_{name}" if name[0].isdigit() else name


def dds_type(name: str) -> str:
    """Return a type's name as DDS has it: std_msgs/msg/String is `std_msgs::msg::dds_::String_`."""
    package, kind, type_name = name.split("/")
    return f"{package}::{kind}::dds_::{type_name}_"


def topic_key(domain: int, topic: str, type_name: str, type_hash: str) -> str:
    """Return the key of a topic or service: `<domain>/<name>/<type>/<hash>`."""
    return f"{domain}/{topic.strip('/')}/{dds_type(type_name)}/{type_hash}"


def mangled(name: str) -> str:
    """Return a name with `%` for each `/`."""
    return name.replace("/", "%")


@dataclass(frozen=True)
class NodeName:
    """A node.

    Attributes:
        domain: ROS_DOMAIN_ID. session: identity of its Zenoh session, hexadecimal.
        namespace: with a leading slash. name: without one.
    """

    domain: int
    session: str
    namespace: str
    name: str

    def token(self) -> str:
        """Return the liveliness token of the node, which is number 0 of its session."""
        return self._token(0, Kind.NODE)

    def entity_token(self, number: int, kind: Kind, topic: str, type_name: str, type_hash: str, qos: Qos) -> str:
        """Return the liveliness token of a publisher, subscription or service.

        Args:
            number: of the entity in its session, unique.
            kind: of the entity.
            topic: name with namespace and leading slash.
            type_name: as ROS has it.
            type_hash: of that.
            qos: offered or asked for.
        """
        return f"{self._token(number, kind)}/{mangled(topic)}/{dds_type(type_name)}/{type_hash}/{qos}"

    def _token(self, number: int, kind: Kind) -> str:
        place = f"{ADMIN_SPACE}/{self.domain}/{self.session}/0/{number}/{kind}"
        return f"{place}/%/{mangled(self.namespace)}/{self.name}"


@dataclass(frozen=True)
class Attachment:
    """What goes with each message, request and reply: zenoh::ext's serialisation of two integers and an array.

    Source: rmw_zenoh_cpp/src/detail/attachment_helpers.cpp: int64, int64, and an array of bytes behind its length.

    Attributes:
        sequence: number of the message of its publisher, from 1; of a reply that of the request.
        stamp_ns: wall-clock time at which it was sent [ns].
        gid: identity of the publisher or client, 16 bytes.
    """

    sequence: int
    stamp_ns: int
    gid: bytes

    def encode(self) -> bytes:
        """Return the bytes."""
        return _HEAD.pack(self.sequence, self.stamp_ns, len(self.gid)) + self.gid

    @classmethod
    def decode(cls, data: bytes) -> "Attachment":
        """Return the attachment in these bytes.

        Raises:
            ValueError: they are none.
        """
        if len(data) != _HEAD.size + GID_SIZE:
            raise ValueError("the attachment is not rmw_zenoh's")
        sequence, stamp_ns, size = _HEAD.unpack_from(data)
        if size != GID_SIZE or sequence < 0 or stamp_ns < 0:
            raise ValueError("the attachment is not rmw_zenoh's")
        return cls(sequence, stamp_ns, data[_HEAD.size :])


def gid_of(token: str) -> bytes:
    """Return the identity of an entity, 16 bytes, from its token.

    rmw_zenoh takes another hash (XXH3). Nodes compare an identity with those that the same publisher sent before, so
    it has to be unique and constant, not theirs.
    """
    return hashlib.blake2b(token.encode(), digest_size=GID_SIZE).digest()
