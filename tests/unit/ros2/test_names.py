"""Names on Zenoh are those of rmw_zenoh's design document, and hashes those that ROS 2 computes.

Reference: https://github.com/ros2/rmw_zenoh/blob/rolling/docs/design.md, whose examples are repeated here letter by
letter.
"""

import re

import pytest
import zenoh

from tendond.drivers.ros2.distributions import DISTRIBUTIONS
from tendond.drivers.ros2.names import Attachment, Kind, NodeName, Qos, gid_of, ros_name, topic_key
from tendond.drivers.ros2.topics import RigTopics
from tendond.drivers.ros2.types import NO_HASH, TRIGGER, MalformedError, part_of, types_of
from tendond.schemas.keys import RIG_NAME

ADD = "example_interfaces/srv/AddTwoInts"
STRING = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
ADD_HASH = "RIHS01_e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a"


@pytest.mark.parametrize("distribution", ["jazzy", "kilted", "rolling"])
def test_keys_are_those_of_the_design_document(distribution: str) -> None:
    types = types_of(distribution)
    assert topic_key(0, "/robot1/chatter", "std_msgs/msg/String", types.hash_of("std_msgs/msg/String")) == (
        f"0/robot1/chatter/std_msgs::msg::dds_::String_/{STRING}"
    )
    assert topic_key(2, "/add_two_ints", ADD, types.hash_of(ADD)) == (
        f"2/add_two_ints/example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}"
    )


def test_tokens_are_those_of_the_design_document() -> None:
    node = NodeName(2, "8b20917502ee955ac4476e0266340d5c", "/", "talker")
    assert node.token() == "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/0/NN/%/%/talker"
    assert node.entity_token(10, Kind.PUBLISHER, "/chatter", "std_msgs/msg/String", STRING, Qos(7)) == (
        "@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/%chatter/"
        f"std_msgs::msg::dds_::String_/{STRING}/::,7:,:,:,,"
    )
    server = NodeName(2, "f9980ee0495eaafb3e38f0d19e2eae12", "/", "add_two_ints_server")
    assert server.entity_token(10, Kind.SERVICE, "/add_two_ints", ADD, ADD_HASH, Qos()) == (
        "@ros2_lv/2/f9980ee0495eaafb3e38f0d19e2eae12/0/10/SS/%/%/add_two_ints_server/%add_two_ints/"
        f"example_interfaces::srv::dds_::AddTwoInts_/{ADD_HASH}/::,10:,:,:,,"
    )


def test_every_type_of_a_rig_has_the_same_hash_in_all_distributions_but_humble_which_has_none() -> None:
    names = [*{topic.type_name for topic in RigTopics("paper").published}, "geometry_msgs/msg/PoseStamped", TRIGGER]
    for name in names:
        hashes = {distribution: types_of(distribution).hash_of(name) for distribution in DISTRIBUTIONS}
        assert hashes.pop("humble") == NO_HASH
        assert len(set(hashes.values())) == 1
        assert re.fullmatch(r"RIHS01_[0-9a-f]{64}", hashes["jazzy"])


def test_an_attachment_is_what_zenohs_own_serialisation_makes() -> None:
    gid = gid_of("@ros2_lv/0/1/0/1/MP/%/%/talker")
    theirs = zenoh.ext.z_serialize((zenoh.ext.Int64(5), zenoh.ext.Int64(7), gid)).to_bytes()
    assert Attachment(5, 7, gid).encode() == theirs
    assert Attachment.decode(theirs) == Attachment(5, 7, gid)
    for wrong in (b"", theirs[:-1], theirs + b"\0", theirs[:16] + b"\x11" + theirs[17:], b"\xff" * len(theirs)):
        with pytest.raises(ValueError, match="attachment"):
            Attachment.decode(wrong)


@pytest.mark.parametrize("rig", ["paper", "lab-3", "3arm", "a--b", "a_-_b", "x-", "0", "--"])
def test_a_rigs_name_becomes_one_that_ros_allows(rig: str) -> None:
    """Rule: https://design.ros2.org/articles/topic_and_service_names.html, of a token of a name."""
    assert re.fullmatch(r"[A-Za-z_](?:_?[A-Za-z0-9])*_?", ros_name(rig))
    assert "__" not in ros_name(rig)
    if rig == "paper":
        assert RIG_NAME.fullmatch(ros_name(rig))


@pytest.mark.parametrize(
    "payload", [b"", b"\0\1", b"{}", b"\0\1\0\0", b"\0\7\0\0" + bytes(200), b"\0\1\0\0" + b"\xff" * 99]
)
def test_what_is_no_message_is_refused(payload: bytes) -> None:
    with pytest.raises(MalformedError):
        types_of("jazzy").decode("geometry_msgs/msg/PoseStamped", payload)


def test_an_empty_request_is_the_five_bytes_that_ros_sends() -> None:
    types = types_of("jazzy")
    request = types.make(part_of(TRIGGER, "Request"))
    assert types.encode(request) == b"\0\1\0\0\0"
