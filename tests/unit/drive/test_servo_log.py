"""A servo's dynamics from a run's commands and reports: what the servo has is found, and what the log lacks is said."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendond.cli.servo.identify import identify_from_log, report
from tendond.model.tendons.servo import ServoDynamics, advance, at_rest
from tendond.offline.identification.recordings.recording import DataError, Recording
from tendond.offline.identification.servo_log import fit_recording
from tests.golden.scripts import FOLDER
from tests.unit.identification.recordings import CONFIG, PERIOD

SERVO = ServoDynamics(rate=0.085, acceleration=3.0, lag=0.015, backlash=1e-4)
DEAD_TIME, NOISE = 0.012, 1e-5
FINE = 0.001
"""Time step of the servo here [s]; the fit has none."""


def run(amplitude: float, seconds: float = 6.0) -> Recording:
    """Sweeps and jumps of one tendon, and a servo that follows them; reports have noise and come between commands."""
    times = np.asarray(PERIOD * np.arange(round(seconds / PERIOD)), dtype=np.float64)
    goals = amplitude * (np.sin(2.0 * np.pi * 0.6 * times) + 0.5 * np.sign(np.sin(2.0 * np.pi * 0.35 * times)))
    state, found = at_rest(float(goals[0])), []
    fine = FINE * np.arange(round(seconds / FINE))
    for time in fine:
        found.append(state.end)
        at = int(np.searchsorted(times, time - DEAD_TIME + 1e-9, side="right")) - 1
        state = advance(SERVO, state, float(goals[max(at, 0)]), FINE)
    report_times = np.asarray(times[:-1] + 0.004, dtype=np.float64)
    reported = np.interp(report_times, fine, found) + NOISE * np.random.default_rng(3).standard_normal(len(times) - 1)
    command, still = np.column_stack([goals, 0.0 * goals]), np.zeros((len(times), 3))
    return Recording(
        path=Path("run.mcap"), config=CONFIG, weight=0.0, period=PERIOD, times=times, armed=np.ones(len(times), bool),
        command=command, report_times=report_times, reported=np.column_stack([reported, 0.0 * reported]),
        pulled=np.zeros((len(report_times), 2)), pose_times=times, position=still, noise=1e-4, cycles=len(times),
        hidden=0, limited=0.0, missed=0, fault="",
    )  # fmt: skip


def test_the_dynamics_are_those_of_the_servo() -> None:
    fit, backlash = fit_recording(run(0.012), 0, 0.06, 6.0)
    assert fit.servo.rate == pytest.approx(SERVO.rate, rel=0.02)
    assert fit.servo.acceleration == pytest.approx(SERVO.acceleration, rel=0.1)
    assert fit.dead_time + fit.servo.lag == pytest.approx(DEAD_TIME + SERVO.lag, abs=1e-3)
    assert backlash == pytest.approx(SERVO.backlash, abs=3e-5)
    assert fit.residual < 3.0 * NOISE
    assert "\nrate = 0.08" in report(fit, backlash, 0.015)


def test_a_slow_motion_does_not_show_the_rate() -> None:
    slow = run(0.012)
    smooth = np.column_stack([0.003 * np.sin(2.0 * np.pi * 0.3 * slow.times), 0.0 * slow.times])
    late = np.column_stack([np.interp(slow.report_times - 0.03, slow.times, column) for column in smooth.T])
    noise = NOISE * np.random.default_rng(5).standard_normal(late.shape)
    fit, backlash = fit_recording(replace(slow, command=smooth, reported=late + noise), 0, 0.085, 3.0)
    text = report(fit, backlash, 0.015)
    assert "not shown by this motion" in text
    assert "\nrate = " not in text


def test_what_a_log_lacks_is_said_in_one_line() -> None:
    good = run(0.012, 2.0)
    cases = {
        "there is no tendon 2: they are 0 to 1": (good, 2),
        "tendon 1 moved by 0.0 mm: 2 mm or more are needed": (good, 1),
        "has 0 reports of servo 0 while armed": (replace(good, armed=np.zeros(len(good.times), bool)), 0),
        "ideal drive has no servos": (replace(good, ideal_drive=True), 0),
    }
    for said, (recording, tendon) in cases.items():
        with pytest.raises(DataError, match=said) as caught:
            fit_recording(recording, tendon, 0.085, 3.0)
        assert "\n" not in str(caught.value)


def test_a_log_without_servos_is_refused() -> None:
    with pytest.raises(DataError, match=r"normal\.mcap: a simulator's ideal drive has no servos"):
        identify_from_log(FOLDER / "normal.mcap", 0)
