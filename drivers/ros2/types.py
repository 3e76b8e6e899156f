"""ROS 2's message and service types, without an installation of ROS: definitions, CDR, type hashes.

The definitions are those of `rosbags` (https://ternaris.gitlab.io/rosbags), which also serialises to CDR. Type hashes
are those of REP-2016 (RIHS01); a service is hashed as a type with its request, response and event as fields, as
rosidl_generator_type_description does.
"""

from collections.abc import Mapping
from functools import cache
from typing import Any

from rosbags.interfaces import Nodetype
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from tendond.drivers.ros2.distributions import DISTRIBUTIONS

NO_HASH = "TypeHashNotSupported"
"""What rmw_zenoh_cpp puts in place of a hash on Humble, whose rosidl has none (its branch humble)."""

SERVICES: Mapping[str, tuple[str, str]] = {
    "std_srvs/srv/Trigger": ("", "bool success\nstring message"),
    "example_interfaces/srv/AddTwoInts": ("int64 a\nint64 b", "int64 sum"),
}
"""Request and response by service type; the second is the example in rmw_zenoh's design document."""

TRIGGER = "std_srvs/srv/Trigger"
EVENT_INFO = "service_msgs/msg/ServiceEventInfo"
PARTS = ("Request", "Response", "Event")


class MalformedError(Exception):
    """Bytes that are not a message of the expected type."""


class Types:
    """Types of a distribution.

    Args:
        distribution: one of `DISTRIBUTIONS`.
    """

    def __init__(self, distribution: str) -> None:
        store = "ROS2_LYRICAL" if distribution == "rolling" else f"ROS2_{distribution.upper()}"
        self.distribution = distribution
        self._store = get_typestore(Stores[store])
        for name, (request, response) in SERVICES.items():
            for part, text in (("Request", request), ("Response", response)):
                self._store.register(get_types_from_msg(text, f"{name}_{part}"))

    @property
    def store(self) -> Typestore:
        """The types, for a writer of bags."""
        return self._store

    def make(self, type_name: str, /, **fields: Any) -> Any:
        """Return a message of a type, with all of its fields."""
        return self._store.types[type_name](**fields)

    def encode(self, message: Any) -> bytes:
        """Return the message as CDR, little-endian, with its encapsulation header."""
        return bytes(self._store.serialize_cdr(message, message.__msgtype__))

    def decode(self, name: str, payload: bytes) -> Any:
        """Return the message of a type in CDR.

        Raises:
            MalformedError: it is none.
        """
        if len(payload) < 4 or payload[0] != 0 or payload[1] not in (0, 1):
            raise MalformedError("no CDR encapsulation")
        try:
            return self._store.deserialize_cdr(payload, name)
        except (SerdeError, AssertionError, ValueError, IndexError, MemoryError, OverflowError) as error:
            raise MalformedError(f"is no {name}") from error

    def hash_of(self, name: str) -> str:
        """Return a message's or service's type hash, as it stands in a key expression."""
        if self.distribution == "humble":
            return NO_HASH
        return _service_hash(name) if name in SERVICES else self._store.hash_rihs01(name)


@cache
def types_of(distribution: str) -> Types:
    """Return the types of a distribution, which are loaded once.

    Raises:
        ModuleNotFoundError: the extra 'ros2' is not installed.
    """
    if distribution not in DISTRIBUTIONS:
        raise ValueError(f"unknown distribution '{distribution}'")
    return Types(distribution)


def part_of(service: str, part: str) -> str:
    """Return the name under which rosbags has a part of a service, 'Request' or 'Response'."""
    return f"{service.replace('/srv/', '/srv/msg/')}_{part}"


@cache
def _service_hash(name: str) -> str:
    """Return the RIHS01 hash of a service, in a store of its own: the names of its parts are not those of rosbags."""
    store = get_typestore(Stores.ROS2_JAZZY)
    definitions: Any = store.fielddefs
    for part, text in zip(("Request", "Response"), SERVICES[name], strict=True):
        (fields,) = get_types_from_msg(text, f"{name}_{part}").values()
        definitions[f"{name}_{part}"] = fields
    constants, event = definitions[EVENT_INFO]
    # rosidl_adapter makes a .msg's char a uint8, as the document's hash of AddTwoInts shows; rosbags keeps it a char
    uint8s = (Nodetype.ARRAY, ((Nodetype.BASE, ("uint8", 0)), 16))
    definitions[EVENT_INFO] = (constants, [(key, uint8s if key == "client_gid" else field) for key, field in event])
    definitions[f"{name}_Event"] = (
        [],
        [
            ("info", (Nodetype.NAME, EVENT_INFO)),
            ("request", (Nodetype.SEQUENCE, ((Nodetype.NAME, f"{name}_Request"), 1))),
            ("response", (Nodetype.SEQUENCE, ((Nodetype.NAME, f"{name}_Response"), 1))),
        ],
    )
    parts = [(f"{part.lower()}_message", (Nodetype.NAME, f"{name}_{part}")) for part in PARTS]
    definitions[name] = ([], parts)
    return store.hash_rihs01(name)
