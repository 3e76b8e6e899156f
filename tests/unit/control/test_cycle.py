"""The pure cycle: modes, requests, limits, and where the arm ends. The rod is real."""

import math
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, TendonState
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import CONFIG, SETUP, START, armed, follow, go, pose


def test_it_starts_disarmed_and_slack() -> None:
    _, record = go(START, CycleInputs())
    assert record.mode is Mode.IDLE
    assert not record.command.armed
    assert record.command.tension == (0.0,) * 4


def test_it_lands_where_the_papers_robot_lands() -> None:
    """(340.0, 39.8) mm with 58.57 mm of tendon: the paper's scheme and gains, reachable z."""
    records = list(closed_loop(parse_config(PAPER, "paper"), 300, {5: ControlAction.ARM}))
    tip, command = records[-1].measured, records[-1].command
    assert tip is not None
    assert np.allclose(np.array(tip) * 1e3, (340.0, 0.0, 39.8), atol=0.5)
    assert command.displacement[0] * 1e3 == pytest.approx(58.6, abs=0.1)


def test_a_converged_rod_lands_where_its_own_statics_say() -> None:
    """The paper's Euler scheme is 8 mm off in z at this bend; the default scheme rests at (340.0, 47.5), 57.6 mm."""
    tip = list(closed_loop(CONFIG, 300, {5: ControlAction.ARM}))[-1]
    assert tip.measured is not None
    assert np.allclose(np.array(tip.measured) * 1e3, (340.0, 0.0, 47.5), atol=0.1)
    assert tip.command.displacement[0] * 1e3 == pytest.approx(57.6, abs=0.1)


def test_it_lands_when_servos_wind_elastic_tendons() -> None:
    """The plant takes displacements; the controller knows the tendons' stretch and leaves slack ones 2 mm."""
    elastic = "tendon_stiffness = 2.0e4\n"
    config = parse_config(
        f'[rod]\n{elastic}[limits]\nslack = 0.002\n[simulator]\ndrive = "displacement"\n[simulator.rod]\n{elastic}',
        "test",
    )
    last = list(closed_loop(config, 300, {5: ControlAction.ARM}))[-1]
    assert last.measured is not None
    assert np.allclose(np.array(last.measured) * 1e3, (340.0, 0.0, 47.5), atol=0.1)
    assert last.inputs.tendon_state is not None
    pulled = np.array(last.inputs.tendon_state.tension)
    assert pulled[0] == pytest.approx(last.tension_estimate[0], abs=0.01)
    assert np.all(pulled[1:] == 0.0)


def test_step_does_not_change_the_state_it_is_given() -> None:
    state = armed()
    inputs = CycleInputs(pose=follow(state))
    first = step(SETUP, state, inputs)[2].model_dump_json()
    step(SETUP, step(SETUP, state, inputs)[0], CycleInputs())
    assert step(SETUP, state, inputs)[2].model_dump_json() == first


def test_arming_is_refused_without_a_pose() -> None:
    _, record = go(START, CycleInputs(request=ControlAction.ARM))
    assert (record.accepted, record.mode) == (False, Mode.IDLE)
    assert "no pose" in record.reply


def test_arming_is_refused_when_the_pose_is_old() -> None:
    state, _ = go(START, CycleInputs(pose=pose(0)), *[CycleInputs()] * 25)
    _, record = go(state, CycleInputs(request=ControlAction.ARM))
    assert (record.accepted, record.mode) == (False, Mode.IDLE)
    assert "the newest pose is 0.26 s old" in record.reply


def test_stop_releases_and_comes_to_idle() -> None:
    state, record = go(armed(), CycleInputs(request=ControlAction.STOP))
    assert (record.mode, record.accepted) == (Mode.RELEASING, True)
    before = record.tension_estimate[0]
    state, record = go(state, CycleInputs())
    assert record.tension_estimate[0] < before
    _, record = go(state, *[CycleInputs()] * 120)
    assert (record.mode, record.tension_estimate, record.command.armed) == (Mode.IDLE, (0.0,) * 4, False)


def test_law_and_reference_change_while_idle_and_show_in_the_record() -> None:
    section = ReferenceSection(across=0.25, kind="minimum_jerk")
    state, record = go(
        START,
        CycleInputs(pose=pose(0)),
        CycleInputs(pose=pose(1), request=ControlAction.LAW, law="sliding_mode"),
    )
    assert (record.accepted, record.reply, record.law) == (True, "law: sliding_mode", "sliding_mode")
    state, record = go(state, CycleInputs(pose=pose(2), request=ControlAction.REFERENCE, reference=section))
    assert record.accepted
    assert record.reference.target[0] == pytest.approx(0.25)
    state, record = go(state, CycleInputs(pose=pose(3), request=ControlAction.ARM))
    for _ in range(30):
        state, record = go(state, CycleInputs(pose=follow(state)))
    assert record.mode is Mode.TRACKING
    assert record.law == "sliding_mode"
    assert START.selection.law_name == "backstepping"


@pytest.mark.parametrize(
    ("inputs", "why"),
    [
        ({"request": ControlAction.LAW, "law": "pid"}, "no law is called 'pid'; choose one of backstepping"),
        ({"request": ControlAction.REFERENCE, "reference": ReferenceSection(across=2.0)}, "the nearest is"),
        ({"request": ControlAction.LAW}, "does not say to what"),
    ],
)
def test_a_law_or_reference_that_cannot_be_is_refused_with_the_reason(inputs: dict[str, Any], why: str) -> None:
    state, record = go(START, CycleInputs(pose=pose(0)), CycleInputs(pose=pose(1), **inputs))
    assert not record.accepted
    assert why in record.reply
    assert state.selection == START.selection


def test_law_and_reference_are_refused_while_anything_moves() -> None:
    state = armed()
    _, record = go(state, CycleInputs(pose=follow(state), request=ControlAction.LAW, law="sliding_mode"))
    assert (record.accepted, record.reply) == (False, "not changed: tracking; stop first")


def test_a_recorded_run_with_requests_repeats_from_its_inputs() -> None:
    inputs = [CycleInputs(pose=pose(k)) for k in range(60)]
    inputs[2] = CycleInputs(pose=pose(2), request=ControlAction.LAW, law="sliding_mode")
    inputs[3] = CycleInputs(pose=pose(3), request=ControlAction.REFERENCE, reference=ReferenceSection(across=0.2))
    inputs[5] = CycleInputs(pose=pose(5), request=ControlAction.ARM)

    def run(inputs: list[CycleInputs]) -> list[str]:
        state, lines = START, []
        for one in inputs:
            state, record = go(state, one)
            lines.append(record.model_dump_json())
        return lines

    lines = run(inputs)
    assert run([CycleRecord.model_validate_json(line).inputs for line in lines]) == lines


def test_a_driver_with_another_number_of_tendons_keeps_the_arm_disarmed() -> None:
    three = TendonState(seq=1, stamp_ns=0, displacement=(0.0,) * 3, tension=(0.0,) * 3)
    _, record = go(START, CycleInputs(pose=pose(0), tendon_state=three, request=ControlAction.ARM))
    assert not record.accepted
    assert "rod.tendon_positions has 4" in record.reply


def test_velocity_from_differences_knows_how_far_the_poses_are_apart() -> None:
    """Poses every second cycle of a direct controller: the same motion, so the same velocity, not half of it."""
    setup = CycleSetup.from_config(
        parse_config('[control]\nfeedback = "direct"\n[commissioning]\nrest = false\nprobe = false\n', "test")
    )
    state, seq = initial_state(setup), 0

    def move(state: CycleState, x: float, request: ControlAction | None = None) -> tuple[CycleState, CycleRecord]:
        nonlocal seq
        seq += 1
        state, _, record = step(setup, state, CycleInputs(pose=pose(seq, (x, 0.0, 0.49)), request=request))
        return state, record

    state, _ = move(state, 0.0, ControlAction.ARM)
    for k in range(1, 25):
        state, record = move(state, 0.001 * k)
    assert record.estimate is not None
    assert record.estimate.velocity[0] == pytest.approx(0.1)
    state, _, _ = step(setup, state, CycleInputs())
    _, record = move(state, 0.001 * 26)
    assert record.estimate is not None
    assert record.estimate.velocity[0] == pytest.approx(0.1)


def test_the_same_inputs_give_the_same_bytes() -> None:
    first, second = (
        [record.model_dump_json() for record in closed_loop(CONFIG, 80, {3: ControlAction.ARM})] for _ in range(2)
    )
    assert first == second


def test_a_model_that_is_lost_starts_at_rest_again_once_the_arm_is_released() -> None:
    """Poses where no arm can hang: the model cannot follow them, and must not stay wherever it was pulled."""
    state, _ = go(START, CycleInputs(pose=pose(0, (0.0, 0.0, -0.45))))
    forces = []
    for seq in range(1, SETUP.thresholds.mismatch_time + 30):
        state, record = go(state, CycleInputs(pose=pose(seq, (0.0, 0.0, -0.45))))
        forces.append(math.hypot(*record.observer.force))
    assert record.mode is Mode.IDLE
    assert max(forces[: SETUP.thresholds.mismatch_time]) > 0.05
    assert min(forces[SETUP.thresholds.mismatch_time - 5 : SETUP.thresholds.mismatch_time + 5]) < 0.01
