"""Replies to an operator in each mode, and the mode that a request leads to."""

import numpy as np
import pytest

from tendond.daemon.control.phases.modes import change_mode, handle_request, pulls
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import SETUP, START, armed

TRACKING = armed()
IDLE = changed(START, mode=Mode.IDLE, reason="started")
FAULT = changed(START, mode=Mode.FAULT, reason="teleport: of all things")
LITTLE = np.array([0.0, 0.0, 1e-3, 0.0])


@pytest.mark.parametrize(
    ("state", "action", "mode", "reason", "accepted", "text"),
    [
        (TRACKING, ControlAction.STOP, Mode.RELEASING, "asked to stop", True, "stopped: releasing the tendons"),
        (FAULT, ControlAction.STOP, Mode.FAULT, FAULT.reason, True, "in fault: the tendons are released already"),
        (IDLE, ControlAction.STOP, Mode.IDLE, "started", True, "nothing to stop: idle"),
        (FAULT, ControlAction.RESET, Mode.IDLE, "reset by the operator", True, "reset"),
        (
            changed(FAULT, tension_command=LITTLE),
            ControlAction.RESET,
            Mode.FAULT,
            FAULT.reason,
            False,
            "not reset: the tendons are still being released",
        ),
        (IDLE, ControlAction.RESET, Mode.IDLE, "started", False, "nothing to reset: idle"),
        (
            FAULT,
            ControlAction.ARM,
            Mode.FAULT,
            FAULT.reason,
            False,
            "not armed: in fault (teleport: of all things); reset first",
        ),
        (TRACKING, ControlAction.ARM, Mode.TRACKING, TRACKING.reason, False, "not armed: already tracking"),
        (IDLE, ControlAction.ARM, Mode.IDLE, "started", False, "not armed: no pose of the tip has arrived yet"),
        (IDLE, ControlAction.PROBE, Mode.IDLE, "started", False, "not probed: no pose of the tip has arrived yet"),
        (FAULT, ControlAction.LAW, Mode.FAULT, FAULT.reason, False, "not changed: fault; reset first"),
        (TRACKING, ControlAction.LAW, Mode.TRACKING, TRACKING.reason, False, "not changed: tracking; stop first"),
        (IDLE, ControlAction.LAW, Mode.IDLE, "started", False, "not changed: the request does not say to what"),
        (IDLE, ControlAction.STATUS, Mode.IDLE, "started", True, "idle"),
    ],
)
def test_a_request_gets_the_reply_of_the_mode_it_finds(
    state: CycleState, action: ControlAction, mode: Mode, reason: str, accepted: bool, text: str
) -> None:
    after, reply = handle_request(SETUP, state, CycleInputs(request=action))
    assert (after.mode, after.reason) == (mode, reason)
    assert (reply.accepted, reply.text) == (accepted, text)


@pytest.mark.parametrize("name", ["tension_command", "tension_estimate"])
def test_a_tendon_pulls_while_it_is_commanded_or_has_not_followed_yet(name: str) -> None:
    assert pulls(START) is False
    assert pulls(changed(START, **{name: LITTLE})) is True


def test_a_model_that_was_lost_starts_at_rest_once_after_its_time_and_not_while_a_tendon_pulls() -> None:
    lost = changed(
        IDLE,
        rod=TRACKING.rod,
        tip=TRACKING.tip,
        bad_cycles=changed(IDLE.bad_cycles, mismatches=SETUP.thresholds.mismatch_time),
    )
    again = change_mode(SETUP, lost)
    assert again.tip.position == pytest.approx(START.tip.position, abs=1e-6)
    assert again.bad_cycles.mismatches == 0
    early = changed(lost, bad_cycles=changed(lost.bad_cycles, mismatches=SETUP.thresholds.mismatch_time - 1))
    for held in (early, changed(lost, tension_command=LITTLE), changed(lost, tension_estimate=LITTLE)):
        assert change_mode(SETUP, held).tip is lost.tip
