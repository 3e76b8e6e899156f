"""Feed-forward of the servos: what it adds to a command, and that it keeps a tendon at rest still."""

from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.servos import QUIET, ServoMotion, compensate, configured_servo, servos_at
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.tendons.servo import ServoDynamics, advance, at_rest
from tendond.schemas.config.presets import RIG
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction

PERIOD = 0.01
SERVO = ServoDynamics(rate=0.085, acceleration=3.0, backlash=6.5e-5)


def commands(servo: ServoDynamics, wanted: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Commands for one tendon that should be at `wanted` [m], shape (k,)."""
    motion: ServoMotion = servos_at(wanted[:1])
    found = []
    for one in wanted:
        beyond, motion = compensate(servo, motion, np.array([one]), PERIOD)
        found.append(float(one + beyond[0]))
    return np.array(found)


def swinging(seconds: float = 4.0, period: float = 2.0) -> np.ndarray[Any, Any]:
    return 0.02 * np.sin(2.0 * np.pi * np.arange(0.0, seconds, PERIOD) / period)


def error_of(servo: ServoDynamics, goals: np.ndarray[Any, Any], wanted: np.ndarray[Any, Any]) -> float:
    """Largest distance of the tendon's end from `wanted` [m] in the second half, a delay of a cycle left out."""
    state, ends = at_rest(float(goals[0])), []
    for goal in goals:
        state = advance(servo, state, float(goal), PERIOD)
        ends.append(state.end)
    half = len(ends) // 2
    return float(np.max(np.abs(np.array(ends)[half:] - wanted[half:])))


def test_a_servo_with_profile_and_play_follows_with_a_third_of_the_error_that_it_has_alone() -> None:
    wanted = swinging()
    alone, led = (error_of(SERVO, goals, wanted) for goals in (wanted, commands(SERVO, wanted)))
    assert alone > 0.5e-3
    assert led < 0.34 * alone


def test_noise_of_a_tendon_at_rest_moves_no_servo() -> None:
    rest = 0.01 + 0.9 * QUIET * SERVO.backlash * np.random.default_rng(0).uniform(-1.0, 1.0, 500)
    still = commands(SERVO._replace(acceleration=0.0), rest)[100:]
    assert np.ptp(still) < 0.02 * np.ptp(rest)
    assert np.ptp(rest) > 1e-5


def test_after_a_reversal_the_play_is_filled_at_a_bounded_rate() -> None:
    wanted = np.concatenate([np.arange(0.0, 1e-3, 1e-5), np.arange(1e-3, 0.0, -1e-5)])
    given = commands(SERVO._replace(acceleration=0.0), wanted)
    assert given[90] - wanted[90] == pytest.approx(0.5 * SERVO.backlash)
    assert given[190] - wanted[190] == pytest.approx(-0.5 * SERVO.backlash)
    assert np.max(np.abs(np.diff(given))) < 3.0 * 1e-5 + 1e-12


def test_a_rig_that_names_neither_profile_nor_play_is_led_by_nothing() -> None:
    assert configured_servo(parse_config("[observer]\nlag = 0.02\ncommand_delay = 0.01", "test")) is None
    named = configured_servo(parse_config(RIG, "test"))
    assert named is not None
    assert (named.acceleration, named.backlash) == (3.0, 6.5e-5)


def test_a_dead_time_that_is_configured_is_led_by_the_reference() -> None:
    """With it, the tip of a plant whose servos lag is where the reference is; without, it is late by the lag."""
    rig = RIG.replace("friction = 0.2", "friction = 0.0").replace("noise = 0.0001", "noise = 0.0")

    def late(text: str) -> float:
        part = [
            one
            for one in watched_loop(parse_config(text, "test"), 150, {5: ControlAction.ARM})
            if one.record.mode is Mode.TRACKING
        ]
        tip = np.array([one.truth.position[0] for one in part])
        target = np.array([one.record.reference.position[0] for one in part])
        fast = slice(60, 120)  # the minimum-jerk reference passes its largest speed
        return float(np.mean((target - tip)[fast]) / np.mean(np.gradient(target, PERIOD)[fast]))

    assert late(rig.replace("command_delay = 0.018\n", "")) == pytest.approx(0.018, abs=0.004)
    assert abs(late(rig)) < 0.005


def test_a_late_pose_is_compared_with_the_model_of_its_own_time() -> None:
    """Poses of a tip that moves, of alternating age: with their stamps the innovation does not alternate."""

    def innovations(text: str) -> np.ndarray[Any, Any]:
        config = parse_config(
            "[commissioning]\nprobe = false\nrest = false\n[observer]\ndelay = 0.015\n" + text, "test"
        )
        setup = CycleSetup.from_config(config)
        state: CycleState = initial_state(setup)
        tips, found = [state.tip.position], []
        for tick in range(60):
            age = 1.0 if tick % 2 else 1.5
            newer, older = tips[max(0, len(tips) - 2)], tips[max(0, len(tips) - 3)]
            x, y, z = ((2.0 - age) * newer + (age - 1.0) * older).tolist()
            stamp = round((tick + 10 - age) * 1e7)
            pose = TipPose(seq=tick, stamp_ns=stamp, position=(x, y, z), orientation=(1.0, 0.0, 0.0, 0.0))
            request = ControlAction.ARM if tick == 5 else None
            inputs = CycleInputs(pose=pose, pose_lag=age * 1e-2, request=request)
            state, _, record = step(setup, state, inputs)
            tips.append(state.tip.position)
            found.append(record.observer.innovation)
        assert state.mode is Mode.TRACKING, state.reason
        return np.asarray(np.linalg.norm(found, axis=1))

    assert float(np.max(innovations("stamps = true")[30:])) < 1e-9
    assert float(np.max(innovations("")[30:])) > 1e-3
