"""Requests for faults of the simulator: the former name 'mend' of 'clear' is still read, in code and on the wire."""

import pytest

from tendond.schemas.faults import Fault, FaultRequest
from tendond.schemas.wire import UnreadableError, decode, encode


def test_mend_on_the_wire_is_read_as_clear() -> None:
    assert decode(FaultRequest, b'{"version": 1, "fault": "mend", "servo": 2}') == FaultRequest(
        fault=Fault.CLEAR, servo=2
    )
    assert b'"clear"' in encode(FaultRequest(fault=Fault("mend")))


def test_a_name_that_is_no_fault_is_refused() -> None:
    with pytest.raises(UnreadableError, match="malformed"):
        decode(FaultRequest, b'{"version": 1, "fault": "mended"}')
    with pytest.raises(ValueError, match="mended"):
        Fault("mended")
