"""The cycle with an observer of kind 'kalman': it tracks, says how sure it is, and replays to the last bit."""

import numpy as np
import pytest

from tendond.daemon.control.commissioning.probe import Probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.cycle import step
from tendond.daemon.control.phases.estimation import estimate
from tendond.daemon.control.phases.faults import find_fault
from tendond.daemon.control.sensors import Reading
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState, changed, initial_state
from tendond.drivers.simulator.lockstep import Watched, watched_loop
from tendond.model.errors import ParameterError
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

TEXT = """
[control]
solver = "general"
law = "sensitivity"
[reference]
kind = "circle"
radius = 0.1
period = 3.0
duration = 1.0
[observer]
kind = "kalman"
delay = 0.02
[simulator.mocap]
latency = 0.02
noise = 1e-4
[simulator.rod]
youngs_modulus = 195e9
"""
CONFIG = parse_config(TEXT, "test")
SETUP = CycleSetup.from_config(CONFIG)


@pytest.fixture(scope="module")
def run() -> tuple[list[Watched], list[CycleState]]:
    states: list[CycleState] = []
    trace = list(watched_loop(CONFIG, 420, {40: ControlAction.ARM}, see_state=states.append))
    return trace, states


def test_it_tracks_a_robot_that_is_softer_than_its_model(run: tuple[list[Watched], list[CycleState]]) -> None:
    trace, _ = run
    late = [one for one in trace[250:] if one.record.mode is Mode.TRACKING]
    assert len(late) == len(trace) - 250
    apart = [np.linalg.norm(np.subtract(one.truth.position, one.record.reference.position)) for one in late]
    assert float(np.sqrt(np.mean(np.square(apart)))) < 4e-3


def test_the_record_says_what_it_knows_and_how_surely(run: tuple[list[Watched], list[CycleState]]) -> None:
    trace, _ = run
    known = trace[-1].record.observer.filter
    assert known is not None
    xx, xy, xz, yy, yz, zz = known.tip_covariance
    assert np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])[0] > 0.0
    assert known.stiffness == pytest.approx(195.0 / 209.0, abs=0.1)
    assert len(known.tension_error) == len(known.tension_deviation) == 4
    assert known.load_tick is None
    assert CycleRecord.model_validate_json(trace[-1].record.model_dump_json()) == trace[-1].record


def test_a_cycle_from_its_snapshot_is_the_same_to_the_last_bit(run: tuple[list[Watched], list[CycleState]]) -> None:
    trace, states = run
    for tick in (0, 60, 400):
        again = decode_state(CycleState, encode_state(states[tick]), SETUP)
        assert isinstance(again.observer, EstimatorState)
        after, _, record = step(SETUP, again, trace[tick].record.inputs)
        assert record == trace[tick].record
        assert encode_state(after) == encode_state(states[tick + 1])


def test_a_lost_estimate_is_a_fault_of_its_own(run: tuple[list[Watched], list[CycleState]]) -> None:
    _, states = run
    state = states[300]
    assert isinstance(state.observer, EstimatorState)
    assert find_fault(SETUP, state) == ""
    lost = changed(state, observer=changed(state.observer, consistency=36.0))
    assert find_fault(SETUP, lost).startswith("inconsistency: what is measured is 6.0 times as far from the estimate")
    allowed = changed(state, observer=changed(state.observer, consistency=25.0))
    assert find_fault(SETUP, allowed) == ""


def test_the_shooting_rod_has_no_filter() -> None:
    shooting = parse_config('[observer]\nkind = "kalman"\n[control]\nsolver = "shooting"\n', "test")
    with pytest.raises(ParameterError, match=r'observer\.kind = "kalman" needs the general rod'):
        CycleSetup.from_config(shooting)


def test_with_the_search_for_contacts_a_free_arm_has_none() -> None:
    config = parse_config(TEXT.replace('kind = "kalman"', 'kind = "kalman"\ncontact = true'), "test")
    trace = list(watched_loop(config, 60, {}))
    known = trace[-1].record.observer.filter
    assert known is not None
    assert known.contact is None
    assert "contact" not in known.model_dump_json()


def test_while_the_tendons_are_probed_no_sensor_moves_the_model() -> None:
    """The model runs freely then, to be compared with: neither the pose nor markers correct it."""
    marked = parse_config(TEXT + '[[sensors]]\nname = "skin"\nkind = "markers"\nat = [0.5]\nnoise = 1e-4\n', "test")
    setup = CycleSetup.from_config(marked)
    state = initial_state(setup)
    reading = Reading("skin", ((0.1, 0.0, 0.4),), 0.0)
    probing = changed(state, mode=Mode.PROBE, probe=Probe(phase=Phase.PULL), readings=(reading,))
    after, _ = estimate(setup, probing, False)
    assert after.rod is state.rod
    assert estimate(setup, changed(probing, mode=Mode.IDLE), False)[0].rod is not state.rod
