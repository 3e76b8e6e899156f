"""Bytes from outside are a valid message or are refused with a reason; nothing else can come out."""

import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendond.schemas.messages import LARGEST_PAYLOAD, TendonCommand, TipPose
from tendond.schemas.requests import ControlRequest
from tendond.schemas.wire import UnreadableError, decode, encode

POSE = TipPose(seq=3, stamp_ns=5, position=(0.1, 1 / 3, math.pi), orientation=(0.6, 0.0, 0.8, 0.0))


def changed(**changes: object) -> bytes:
    return json.dumps({**json.loads(encode(POSE)), **changes}).encode()


def reason(payload: bytes) -> str:
    with pytest.raises(UnreadableError) as caught:
        decode(TipPose, payload)
    return caught.value.reason


def test_a_message_survives_the_wire_to_the_last_bit() -> None:
    assert decode(TipPose, encode(POSE)) == POSE


@given(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3))
def test_float64_is_exact_on_the_wire(position: tuple[float, float, float]) -> None:
    pose = POSE.model_copy(update={"position": position})
    assert decode(TipPose, encode(pose)).position == position


@pytest.mark.parametrize(
    ("payload", "expected"),
    [
        (b"", "malformed"),
        (b"{", "malformed"),
        (b"\xff\xfe", "malformed"),
        (b"[]", "malformed"),
        (changed(extra=1), "malformed"),
        (changed(seq=-1), "malformed"),
        (changed(seq="3"), "malformed"),
        (changed(position=[1, 2]), "malformed"),
        (changed(position=[math.nan, 0, 0]), "not finite"),
        (changed(position=[math.inf, 0, 0]), "not finite"),
        (changed(orientation=[1, 1, 0, 0]), "bad quaternion"),
        (changed(version=2), "wrong version"),
        (b" " * (LARGEST_PAYLOAD + 1), "too large"),
    ],
)
def test_what_is_no_pose_is_refused_with_its_reason(payload: bytes, expected: str) -> None:
    assert reason(payload) == expected


@given(st.binary(max_size=200))
def test_random_bytes_never_raise_anything_else(payload: bytes) -> None:
    with pytest.raises(UnreadableError):
        decode(TendonCommand, payload)


@pytest.mark.parametrize("field", ["version", "seq", "stamp_ns", "position", "orientation", "valid"])
def test_a_pose_that_lacks_a_field_is_refused_and_the_field_is_named(field: str) -> None:
    payload = json.loads(encode(POSE))
    del payload[field]
    with pytest.raises(UnreadableError) as caught:
        decode(TipPose, json.dumps(payload).encode())
    assert caught.value.detail.startswith(f"TipPose.{field}: ")
    assert caught.value.reason == "malformed"


def test_a_refused_field_is_named_by_its_path_and_a_long_one_is_cut() -> None:
    with pytest.raises(UnreadableError) as caught:
        decode(TipPose, changed(position=[0.1, "a", 0.3]))
    assert caught.value.detail == "TipPose.position.1: Input should be a valid number"
    with pytest.raises(UnreadableError) as caught:
        decode(TipPose, changed(**{"k" * 5000: 1}))
    assert len(caught.value.detail) < 200


def test_a_request_without_version_is_refused() -> None:
    with pytest.raises(UnreadableError, match="malformed"):
        decode(ControlRequest, b'{"action": "arm"}')
