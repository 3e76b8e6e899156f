"""Direct feedback, the paper's: the law's inputs are the poses themselves, and without one nothing is decided."""

import numpy as np

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import pose

SETUP = CycleSetup.from_config(parse_config('[control]\nfeedback = "direct"\n[commissioning]\nprobe = false\n', "test"))


def go(state: CycleState, *inputs: CycleInputs) -> tuple[CycleState, list[CycleRecord]]:
    records = []
    for one in inputs:
        state, _, record = step(SETUP, state, one)
        records.append(record)
    return state, records


def test_without_poses_the_tensions_are_held_and_then_let_go() -> None:
    state = initial_state(SETUP)
    for seq in range(60):
        tip = tuple(SETUP.rod.tip(state.rod).position.tolist())
        request = ControlAction.ARM if seq == 1 else None
        state, (record,) = go(state, CycleInputs(pose=pose(seq, tip), request=request))
    assert record.mode is Mode.TRACKING
    held = record.command.tension
    assert max(held) > 1.0

    patience = SETUP.thresholds.pose_timeout
    state, blind = go(state, *[CycleInputs()] * patience)
    assert {record.mode for record in blind} == {Mode.TRACKING}
    assert {record.command.tension for record in blind} == {held}  # to the last bit
    assert all(record.estimate is None and record.wanted is None for record in blind)

    down = SETUP.config.limits.release_rate * SETUP.config.loop.period
    state, after = go(state, *[CycleInputs()] * (int(max(held) / down) + 20))
    assert {record.mode for record in after} == {Mode.FAULT}
    assert after[0].reason.startswith("pose stale")
    tensions = np.array([held, *(record.command.tension for record in after)])
    assert np.all(np.diff(tensions, axis=0) <= 0.0)
    assert np.all(np.diff(tensions, axis=0) >= -down - 1e-12)
    assert after[-1].command.tension == (0.0,) * 4
    assert not after[-1].command.armed


def test_one_pose_after_a_gap_is_enough_to_go_on() -> None:
    state = initial_state(SETUP)
    seq = 0
    for k in range(80):
        if k < 50 or k % 3 == 0:
            tip = tuple(SETUP.rod.tip(state.rod).position.tolist())
            seq += 1
            arrived = CycleInputs(pose=pose(seq, tip), request=ControlAction.ARM if k == 1 else None)
        else:
            arrived = CycleInputs()
        state, (record,) = go(state, arrived)
        if k >= 50:
            assert record.mode is Mode.TRACKING
            assert (record.estimate is None) is (arrived.pose is None)
