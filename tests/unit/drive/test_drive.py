"""Drive in the loop, in lockstep: a circle of 250 mm in 4 s through servos, camera and friction of profile `rig`."""

from functools import cache

import pytest

from tendond.offline.drive.cases import Case, cases
from tendond.offline.drive.measure import DriveOutcome, run_case
from tendond.offline.drive.report import CHATTER_N, LIMITED, RMS_MM, SWING_MM, markdown, meets

CASES = {case.name: case for case in cases()}
CONFIGURED = "all configured"
UNKNOWN = "all configured but friction: profile 'rig'"


@cache
def outcome_of(name: str) -> DriveOutcome:
    return run_case(CASES[name])


@pytest.mark.parametrize("name", [CONFIGURED, "all configured, friction 0.1", "emulated servos, all configured"])
def test_a_chain_that_is_configured_meets_the_goals(name: str) -> None:
    outcome = outcome_of(name)
    assert CASES[name].goal
    assert meets(outcome), outcome
    assert abs(outcome.late_ms) < 2.0


@pytest.mark.parametrize("percent", [50, 150])
def test_friction_configured_wrong_by_half_neither_chatters_at_reversals_nor_swings(percent: int) -> None:
    """Along the circle each tendon reverses twice a turn; what is not configured is five times as far off."""
    outcome = outcome_of(f"all, friction at {percent} %")
    assert outcome.mode == "tracking"
    assert max(outcome.chatter_command_n, outcome.chatter_n) < CHATTER_N
    assert outcome.swing_mm < SWING_MM
    assert outcome.limited <= LIMITED
    known, unknown = outcome_of(CONFIGURED).rms_mm, outcome_of(UNKNOWN).rms_mm
    assert known < outcome.rms_mm < 0.7 * unknown


def test_a_configured_friction_takes_most_of_its_error_away() -> None:
    assert outcome_of(CONFIGURED).rms_mm < 0.25 * outcome_of(UNKNOWN).rms_mm


def test_servos_that_are_not_configured_make_the_tip_late() -> None:
    outcome = outcome_of("all configured but the servos")
    assert outcome.late_ms > 15.0
    assert outcome.rms_mm > RMS_MM
    assert not meets(outcome)


def test_an_inverted_lag_multiplies_the_cameras_noise_and_a_dead_time_does_not() -> None:
    inverted, led = outcome_of("all configured, the lag inverted"), outcome_of(CONFIGURED)
    assert inverted.chatter_command_n > 3.0 * led.chatter_command_n
    assert inverted.change_n > 2.0 * led.change_n


def test_a_dead_time_configured_wrong_by_half_makes_no_limit_cycle() -> None:
    outcome = outcome_of("all, dead time at 150 %")
    assert outcome.swing_mm < SWING_MM
    assert outcome.chatter_command_n < CHATTER_N


def test_the_table_has_a_line_for_each_chain_and_names_a_fault() -> None:
    outcome = outcome_of(CONFIGURED)
    nothing = DriveOutcome("fault", "overrun")
    lines = markdown([(CASES[CONFIGURED], outcome), (Case("broken"), nothing)]).splitlines()
    assert len(lines) == 4
    assert f"| {outcome.rms_mm:.2f} |" in lines[2]
    assert lines[3].startswith("| broken | fault: overrun |")
    assert not meets(nothing)
