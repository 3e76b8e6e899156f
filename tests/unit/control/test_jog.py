"""Moving the target by hand, in the pure cycle: bounded, on the curve of resting tips, and held without requests."""

import itertools

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.jog.jog import JogBounds
from tendond.daemon.control.reference.planar import PlanarReference
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import SETUP, START, armed, follow, go, pose

PERIOD = SETUP.config.loop.period
REFERENCE = SETUP.selection.reference
assert isinstance(REFERENCE, PlanarReference)
CURVE = REFERENCE.curve
BOUNDS = JogBounds.of(SETUP.config, CURVE, SETUP.config.limits.tension_max)
EVERY = 5
"""Cycles between two requests: 20 a second."""


def jogged(state: CycleState, speed: float, cycles: int) -> tuple[CycleState, list[CycleRecord]]:
    """Ask for a speed [m/s], again and again."""
    records = []
    for k in range(cycles):
        asks = {"request": ControlAction.JOG, "jog": speed} if k % EVERY == 0 else {}
        state, record = go(state, CycleInputs(pose=follow(state), **asks))
        records.append(record)
    return state, records


def left_alone(state: CycleState, cycles: int) -> tuple[CycleState, list[CycleRecord]]:
    records = []
    for _ in range(cycles):
        state, record = go(state, CycleInputs(pose=follow(state)))
        records.append(record)
    return state, records


def places(records: list[CycleRecord]) -> np.ndarray:
    """Positions of the reference [m], shape (k, 3)."""
    return np.array([record.reference.position for record in records])


@pytest.fixture(scope="module")
def resting() -> CycleState:
    return armed(80)


def test_the_target_moves_along_the_resting_tips_within_speed_and_acceleration_whatever_is_asked(
    resting: CycleState,
) -> None:
    """Nothing jumps, neither when the hand takes over, nor when it turns round, nor at the ends of the workspace."""
    before = [go(resting, CycleInputs(pose=follow(resting)))[1]]
    state, out = jogged(resting, 1e9, 300)
    state, back = jogged(state, -1e9, 1200)
    records = [*before, *out, *back]
    assert {record.mode for record in records} == {Mode.TRACKING}
    assert out[-EVERY].reply == "at the end of the workspace"
    assert back[-EVERY].reply == "at the end of the workspace"
    moved = places(records)
    speeds = np.linalg.norm(np.diff(moved, axis=0), axis=1) / PERIOD
    assert 0.9 * BOUNDS.speed < speeds.max() < 1.01 * BOUNDS.speed
    given = [np.array(record.reference.velocity) for record in records[1:]]
    changes = [abs(np.linalg.norm(late) - np.linalg.norm(early)) for early, late in itertools.pairwise(given)]
    assert max(changes) < 1.01 * BOUNDS.acceleration * PERIOD
    beside = moved[1:, [0, 2]] - np.array([0.0, state.reference_offset])
    nearest = CURVE.nearest(beside)  # one of the curve's samples
    for _ in range(3):
        nearest = nearest + np.sum((beside - CURVE.spline(nearest)) * CURVE.spline(nearest, 1), axis=1)
    assert np.abs(CURVE.spline(nearest) - beside).max() < 1e-9
    assert nearest.min() > BOUNDS.first - 1e-4
    assert nearest.max() < BOUNDS.last + 1e-4
    assert CURVE.tension_at(BOUNDS.last) == pytest.approx(0.9 * SETUP.config.limits.tension_max, rel=1e-3)
    assert np.linalg.norm(moved[0] - moved[1]) < 1e-4


def test_without_requests_it_slows_down_and_holds_its_place(resting: CycleState) -> None:
    state, records = jogged(resting, -BOUNDS.speed, 100)
    moving = np.linalg.norm(records[-1].reference.velocity)
    assert moving == pytest.approx(BOUNDS.speed, rel=0.01)
    state, after = left_alone(state, BOUNDS.timeout + round(BOUNDS.speed / BOUNDS.acceleration / PERIOD) + EVERY)
    assert after[-1].reference.velocity == (0.0, 0.0, 0.0)
    state, held = left_alone(state, 50)
    assert np.ptp(places(held), axis=0).max() == 0.0
    assert held[-1].mode is Mode.TRACKING
    assert held[-1].reference.target != resting.selection.reference.target
    tip = SETUP.rod.tip(state.rod).position
    assert np.linalg.norm(tip - places(held)[-1]) < 2e-3  # the arm is there


@pytest.mark.parametrize("mode", ["idle", "stopped"])
def test_it_is_refused_where_nothing_tracks_and_a_stop_ends_it(mode: str, resting: CycleState) -> None:
    state, _ = go(START, CycleInputs(pose=pose(0)))
    if mode == "stopped":
        state, _ = jogged(resting, 0.05, 20)
        state, _ = go(state, CycleInputs(pose=follow(state), request=ControlAction.STOP))
    state, record = go(state, CycleInputs(pose=follow(state), request=ControlAction.JOG, jog=0.05))
    assert not record.accepted
    assert record.reply == f"not moved: {record.mode.value}; arm first"
    assert state.jog is None
    assert state.selection is SETUP.selection


def test_it_waits_for_a_reference_that_is_faster_than_a_hand_may_be() -> None:
    state = armed(22)
    _, record = go(state, CycleInputs(pose=follow(state), request=ControlAction.JOG, jog=0.05))
    assert not record.accepted
    assert "the reference still moves at" in record.reply


def test_a_run_goes_on_to_the_last_bit_from_a_state_as_text_while_the_target_moves(resting: CycleState) -> None:
    state, _ = jogged(resting, -0.07, 23)
    again = decode_state(CycleState, encode_state(state), SETUP)
    for k in range(60):
        asks = {"request": ControlAction.JOG, "jog": 0.03} if k == 7 else {}
        inputs = CycleInputs(pose=follow(state), **asks)
        state, _, record = step(SETUP, state, inputs)
        again, _, replayed = step(SETUP, again, CycleInputs.model_validate_json(inputs.model_dump_json()))
        assert replayed.model_dump_json() == record.model_dump_json()
    assert encode_state(again) == encode_state(state)
    assert ReferenceSection.model_validate(state.selection.to_snapshot()["reference"]) == SETUP.selection.section


def test_a_law_in_space_follows_a_target_that_is_moved_by_hand() -> None:
    """It asks the reference for its goal at the end of the step, which the target's own motion gives."""
    reference = {"across": 0.2, "branch": "below_135", "kind": "minimum_jerk", "duration": 0.3}
    table = {"control": {"law": "sensitivity"}, "reference": reference}
    requests: dict[int, ControlAction | CycleInputs] = {5: ControlAction.ARM}
    requests |= {120 + EVERY * k: CycleInputs(request=ControlAction.JOG, jog=0.08) for k in range(20)}
    records = [one.record for one in watched_loop(check_config(table, "test"), 280, requests)]
    moved = records[120:]
    apart = [np.subtract(one.measured, one.reference.position) for one in moved if one.measured is not None]
    assert len(apart) == len(moved)
    assert np.linalg.norm(places(moved)[-1] - places(moved)[0]) > 0.05
    assert np.abs(apart).max() < 5e-4  # 0.8 mm in a cycle
