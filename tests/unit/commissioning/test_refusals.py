"""Poses that are all refused: the refusal that an operator gets, and what a disarmed controller commands."""

import pytest

from tendond.daemon.control.phases.admission import describe_refusals
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import START, go, pose


def refused(inputs: CycleInputs, count: int) -> str:
    state, record = go(START, *[inputs] * count, CycleInputs(request=ControlAction.ARM))
    assert (record.accepted, record.mode) == (False, Mode.IDLE)
    assert describe_refusals(state) in record.reply
    return record.reply


def test_poses_in_millimetres_are_counted_and_the_unit_is_asked_for() -> None:
    millimetres = pose(1, (-27.6, 0.0, 499.1))
    assert refused(CycleInputs(pose=millimetres), 304) == (
        "not armed: 304 poses arrived, all refused: 304 out of reach (are they in mm? metres are expected)"
    )


def test_a_hidden_tip_and_a_silent_camera_are_distinguished() -> None:
    assert "1 pose arrived, all refused: 1 occluded" in refused(CycleInputs(pose=pose(1, valid=False)), 1)
    _, record = go(START, CycleInputs(request=ControlAction.ARM))
    assert record.reply == "not armed: no pose of the tip has arrived yet"


def test_the_first_malformed_field_is_named_and_stays_the_one_that_is_named() -> None:
    first = CycleInputs(unreadable={"malformed": 3}, unreadable_detail="TipPose.valid: is missing")
    second = CycleInputs(unreadable={"malformed": 1}, unreadable_detail="TipPose.seq: is missing")
    state, _ = go(START, first, second)
    assert describe_refusals(state) == (
        "4 poses arrived, all refused: 4 malformed; malformed messages, the first: TipPose.valid: is missing"
    )
    state, _ = go(state, CycleInputs(pose=pose(1)))
    assert describe_refusals(state) == "malformed messages, the first: TipPose.valid: is missing"


@pytest.mark.parametrize("drive", [pose(1), pose(1, (0.1, 0.0, 0.45))])
def test_a_disarmed_command_asks_for_no_displacement(drive: TipPose) -> None:
    _, record = go(START, CycleInputs(pose=drive), CycleInputs(), CycleInputs())
    assert not record.command.armed
    assert record.command.displacement == record.command.tension == (0.0,) * 4
