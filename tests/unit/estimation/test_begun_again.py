"""An estimate that is lost begins again at rest, and goes on from there."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, changed, initial_state
from tendond.model.estimation.kalman.estimator import LOST
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs

ARM: dict[str, Any] = {"rod": {"damping_ratio": 0.02}, "reference": {"across": 0.2}, "control": {"law": "sensitivity"}}


def setup_with(*, contact: bool) -> CycleSetup:
    return CycleSetup.from_config(check_config({**ARM, "observer": {"kind": "kalman", "contact": contact}}, "arm"))


def posed(setup: CycleSetup, state: CycleState, seq: int) -> CycleState:
    place = tuple(setup.rod.tip(initial_state(setup).rod).position.tolist())
    pose = TipPose(seq=seq, stamp_ns=0, position=place, orientation=(1.0, 0.0, 0.0, 0.0))
    return step(setup, state, CycleInputs(pose=pose))[0]


def lost(state: CycleState) -> CycleState:
    """The same, with an estimate that is far from what is measured and says so."""
    observer = state.observer
    assert isinstance(observer, EstimatorState)
    return changed(state, observer=replace(observer, consistency=2.0 * LOST, force=np.array([0.3, 0.0, 0.0])))


@pytest.mark.parametrize("contact", [False, True])
def test_it_goes_on_from_rest_at_its_tick(contact: bool) -> None:
    setup = setup_with(contact=contact)
    state = initial_state(setup)
    for seq in range(4):
        state = posed(setup, state, seq)
    tick = state.observer.moments[-1].tick if isinstance(state.observer, EstimatorState) else -1
    state = posed(setup, lost(state), 4)
    after = state.observer
    assert isinstance(after, EstimatorState)
    assert after.consistency < LOST
    assert np.linalg.norm(after.force) < 0.15
    assert after.front == tick
    for seq in range(5, 30):
        state = posed(setup, state, seq)
    assert isinstance(state.observer, EstimatorState)
    assert state.observer.front == tick + 25
    assert state.observer.consistency < 5.0


def test_while_it_tracks_a_lost_estimate_is_a_fault_and_stays() -> None:
    setup = setup_with(contact=False)
    state = posed(setup, initial_state(setup), 0)
    tracking = changed(lost(state), mode=Mode.TRACKING, mode_since=state.tick, commissioned=True)
    after = posed(setup, tracking, 1)
    assert after.mode is Mode.FAULT
    assert after.reason.startswith("inconsistency")
