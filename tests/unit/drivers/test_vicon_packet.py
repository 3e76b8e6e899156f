"""Bytes on Tracker's port are a packet of Tracker's or are refused with a reason."""

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendond.drivers.vicon.packet import Block, ObjectReading, PacketError, build, parse

READING = ObjectReading((1.0, -2.5, 1e3), (0.1, 1 / 3, -math.pi))


def by_hand(frame: int, count: int, *items: tuple[int, int, bytes]) -> bytes:
    """A packet written out from the description of the format, not by the code under test."""
    payload = struct.pack("<I", frame) + struct.pack("<B", count)
    for kind, size, data in items:
        payload += struct.pack("<B", kind) + struct.pack("<H", size) + data
    return payload + bytes(256 - len(payload))


def item(name: bytes, *numbers: float) -> tuple[int, int, bytes]:
    return 0, 72, name + bytes(24 - len(name)) + struct.pack("<6d", *numbers)


def reason(payload: bytes) -> str:
    with pytest.raises(PacketError) as caught:
        parse(payload)
    return caught.value.reason


def test_a_packet_written_out_by_hand_is_read() -> None:
    payload = by_hand(77, 2, item(b"tip", 1, 2, 3, 0.1, 0.2, 0.3), item(b"base", 4, 5, 6, 0, 0, 0))
    block = parse(payload)
    assert block.frame == 77
    assert block.objects["tip"] == ObjectReading((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))
    assert block.objects["base"].translation == (4.0, 5.0, 6.0)


@pytest.mark.parametrize(("size", "count"), [(256, 3), (512, 6), (1024, 13)])
def test_each_size_of_packet_is_read_when_full(size: int, count: int) -> None:
    block = Block(2**32 - 1, {f"object {i}": READING for i in range(count)})
    payload = build(block, size)
    assert len(payload) == size
    assert parse(payload) == block


def test_a_name_may_fill_its_24_bytes() -> None:
    block = Block(1, {"x" * 24: READING})
    assert parse(build(block)) == block


def test_items_of_other_kinds_are_passed_over() -> None:
    payload = by_hand(1, 2, (9, 10, bytes(10)), item(b"tip", 1, 2, 3, 0, 0, 0))
    assert list(parse(payload).objects) == ["tip"]


def test_zeros_mean_that_the_object_is_hidden() -> None:
    assert parse(by_hand(1, 1, item(b"tip", 0, 0, 0, 0, 0, 0))).objects["tip"].occluded
    assert not parse(by_hand(1, 1, item(b"tip", 0, 0, 0, 0, 0, 1e-9))).objects["tip"].occluded


@pytest.mark.parametrize(
    ("payload", "expected"),
    [
        (b"", "wrong size"),
        (bytes(255), "wrong size"),
        (bytes(1025), "wrong size"),
        (build(Block(1, {"tip": READING}))[:80], "wrong size"),
        (by_hand(1, 4, *[item(b"tip%d" % i, 1, 2, 3, 0, 0, 0) for i in range(3)]), "wrong item size"),
        (by_hand(1, 1, (0, 300, bytes(100))), "truncated"),
        (by_hand(1, 1, (0, 71, bytes(71))), "wrong item size"),
    ],
)
def test_what_is_no_packet_is_refused_with_its_reason(payload: bytes, expected: str) -> None:
    assert reason(payload) == expected


NEIGHBOURS = {
    "a name in Latin-1": [item("Körper".encode("latin-1"), 1, 2, 3, 0, 0, 0)],
    "a name cut inside a letter": [item("Prüfkörper-Nr-12-größer".encode()[:24], 1, 2, 3, 0, 0, 0)],
    "a name with a tab": [item(b"Paket2\t", 1, 2, 3, 0, 0, 0)],
    "a number that is none": [item(b"wand", math.nan, 2, 3, 0, 0, math.inf)],
    "two of one name": [item(b"wand", 1, 2, 3, 0, 0, 0), item(b"wand", 2, 2, 3, 0, 0, 0)],
}


@pytest.mark.parametrize("others", NEIGHBOURS.values(), ids=NEIGHBOURS.keys())
@pytest.mark.parametrize("first", [True, False])
def test_another_groups_object_costs_the_robots_own_nothing(others: list[tuple[int, int, bytes]], first: bool) -> None:
    own = [item(b"tip", 1, 2, 3, 0.1, 0.2, 0.3)]
    items = [*own, *others] if first else [*others, *own]
    assert parse(by_hand(1, len(items), *items)).objects["tip"] == ObjectReading((1.0, 2.0, 3.0), (0.1, 0.2, 0.3))


@pytest.mark.parametrize(
    ("items", "fault"),
    [
        ([item(b"tip", math.nan, 2, 3, 0, 0, 0)], "not finite"),
        ([item(b"tip", 1, 2, 3, 0, 0, math.inf)], "not finite"),
        ([item(b"tip", 1, 2, 3, 0, 0, 0), item(b"tip", 1, 2, 4, 0, 0, 0)], "twice in the frame"),
        ([item(b"tip", 1, 2, 3, 0, 0, 0), item(b"tip", math.nan, 2, 3, 0, 0, 0)], "not finite"),
    ],
)
def test_an_object_that_cannot_be_used_has_no_reading_and_a_reason(
    items: list[tuple[int, int, bytes]], fault: str
) -> None:
    block = parse(by_hand(1, len(items), *items))
    assert "tip" not in block.objects
    assert block.faults == {"tip": fault}


def test_an_object_that_is_sent_twice_alike_is_one_object() -> None:
    block = parse(by_hand(1, 2, *2 * [item(b"tip", 1, 2, 3, 0, 0, 0)]))
    assert (set(block.objects), block.faults) == ({"tip"}, {})


def test_a_configured_name_may_come_in_another_encoding() -> None:
    payload = by_hand(1, 1, item("Körper".encode("cp1252"), 1, 2, 3, 0, 0, 0))
    assert set(parse(payload, {"Körper".encode("cp1252"): "Körper"}).objects) == {"Körper"}


@given(st.one_of(st.binary(max_size=300), st.binary(min_size=256, max_size=256)))
def test_random_bytes_give_finite_numbers_or_a_reason(payload: bytes) -> None:
    try:
        block = parse(payload)
    except PacketError:
        return
    for reading in block.objects.values():
        assert all(map(math.isfinite, (*reading.translation, *reading.rotation)))
