"""Drive in the loop, in lockstep: a circle of 250 mm in 4 s through servos, camera and friction of profile `rig`."""

from functools import cache

import pytest

from tendond.offline.drive.cases import Case, cases
from tendond.offline.drive.measure import DriveOutcome, run_case
from tendond.offline.drive.report import CHATTER_N, RMS_MM, SWING_MM, markdown, meets

CASES = {case.name: case for case in cases()}
CONFIGURED = "all configured: profile 'rig'"


@cache
def outcome_of(name: str) -> DriveOutcome:
    return run_case(CASES[name])


@pytest.mark.parametrize("name", [CONFIGURED, "all configured, friction 0.3", "emulated servos, all configured"])
def test_a_chain_of_which_the_controller_is_told_meets_the_goals(name: str) -> None:
    outcome = outcome_of(name)
    assert CASES[name].goal
    assert meets(outcome), outcome
    assert outcome.rms_mm < 0.6
    assert abs(outcome.late_ms) < 2.0


def test_untold_of_its_servos_the_controller_is_late_by_them() -> None:
    outcome = outcome_of("all, of which only the pose's delay is configured")
    assert outcome.late_ms > 15.0
    assert outcome.rms_mm > RMS_MM
    assert not meets(outcome)


def test_an_inverted_lag_multiplies_the_cameras_noise_and_a_dead_time_does_not() -> None:
    inverted, led = outcome_of("all configured, the lag inverted"), outcome_of(CONFIGURED)
    assert inverted.chatter_command_n > 3.0 * led.chatter_command_n
    assert inverted.change_n > 2.0 * led.change_n


def test_a_chain_told_wrong_by_half_has_no_limit_cycle() -> None:
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
