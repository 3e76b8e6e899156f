"""The margin of the sampled loop: what it predicts happens in the real loop, and the gains keep it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tendond.daemon.control import gains as feedback
from tendond.daemon.control.gains import lowered, observer_gains
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.estimation.margin import (
    GAIN_MARGIN,
    STIFFNESS_RANGE,
    admitted_gains,
    default_tip_mass,
    min_stiffness_ratio,
)
from tendond.model.estimation.poles import FeedbackGains, LawRates, UnknownPlant, loop_poles
from tendond.model.rod.parameters import RodParameters
from tendond.model.rods.selection import rod_from_section
from tendond.offline.robustness.evaluate import evaluate
from tendond.offline.robustness.margins.bent_stiffness import stiffness_rows
from tendond.offline.robustness.margins.loop import LoopRow, run_loop
from tendond.offline.robustness.points import Point
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.requests import ControlAction

ROD = RodParameters()
RATES = LawRates(12.4, 30.0, 100.0)
ASKED = FeedbackGains(integral=5.0, proportional=0.8, derivative=0.15, time=0.07, noise_share=0.75)


def growth(
    gains: FeedbackGains, plant: UnknownPlant, period: float = 0.01, delay: int = 0, ahead: bool = False
) -> float:
    """Growth rate of the slowest decaying (or fastest growing) motion of the loop [1/s]; negative: stable."""
    poles = loop_poles(ROD, period, -0.2, replace(gains, noise_share=1.0), RATES, plant, delay, ahead=ahead)
    return math.log(abs(poles[0])) / period


def critical_integral(mass: float, proportional: float, derivative: float) -> float:
    """Largest stable Li [1/s], by bisection of the loop's poles."""
    low, high = 0.1, 60.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        stable = growth(FeedbackGains(middle, proportional, derivative, 0.07, 1.0), UnknownPlant(mass)) < 0.0
        low, high = (middle, high) if stable else (low, middle)
    return low


@pytest.mark.parametrize("mass", [0.05, 0.1, 0.2])
def test_a_heavy_mass_bounds_the_integral_as_rouths_criterion_of_one_mode_says(mass: float) -> None:
    stiffness = 3.0 * ROD.bending_stiffness / ROD.length**3
    inertia = mass + 33.0 / 140.0 * ROD.mass_per_length * ROD.length  # Rayleigh's third of a cantilever
    damping = ROD.bending_damping[0] / ROD.bending_stiffness
    kp = 0.3
    late = 0.015  # half a cycle of hold, and one from pose to pull
    expected = (damping - late * kp) * (1.0 + kp) * stiffness / inertia
    assert critical_integral(mass, kp, 0.0) == pytest.approx(expected, rel=0.12)


def ripple(gains: tuple[float, float, float], mass: float, monkeypatch: pytest.MonkeyPatch) -> float:
    """Peak to peak of the true tip's x in the last of eight seconds of the real loop, with these very gains [m]."""
    monkeypatch.setattr(feedback, "_admitted", lambda rod, period, alpha, wanted, *rest: wanted)
    monkeypatch.setattr(feedback, "NOISE_SHARE", 1.0)
    integral, proportional, derivative = gains
    config = parse_config(
        f"[observer]\nintegral = {integral}\nproportional = {proportional}\nderivative = {derivative}\n"
        f"[simulator.weight]\nmass = {mass}\n[commissioning]\nrest = false\nprobe = false\n"
        "[faults]\nswing = 10.0\ntension_swing = 10.0\n",
        "margin",
    )
    x = [watched.truth.position[0] for watched in watched_loop(config, 900, {100: ControlAction.ARM})]
    return float(np.ptp(x[-100:]))


def test_the_real_loop_swings_where_the_poles_say_so_and_settles_where_they_do_not(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bad, good = (12.0, 0.6, 0.02), (2.0, 0.6, 0.1)
    plant = UnknownPlant(0.05, stiffness=0.6)
    assert growth(FeedbackGains(*bad, 0.07, 1.0), plant) > 0.3
    assert growth(FeedbackGains(*good, 0.07, 1.0), plant) < -0.3
    assert ripple(bad, 0.05, monkeypatch) > 0.01  # with the fault that would end it switched off
    assert ripple(good, 0.05, monkeypatch) < 1e-3


@pytest.mark.parametrize("law", ["backstepping", "sensitivity"])
def test_the_real_loop_with_a_hundred_grams_settles_by_default(law: str) -> None:
    case = LoopRow(law, 100.0, 0.1, 0.85, 3, 0, None, None, "", passes=False)
    found = run_loop(RigConfig(), case)
    assert found.passes, found
    assert found.settling is not None
    assert found.settling < 4.0


def test_a_run_that_swings_fails_the_study(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feedback, "_admitted", lambda rod, period, alpha, wanted, *rest: wanted)
    monkeypatch.setattr(feedback, "NOISE_SHARE", 1.0)
    eager = parse_config("[observer]\nintegral = 12.0\nderivative = 0.02\n", "eager")
    found = run_loop(eager, LoopRow("backstepping", 100.0, 0.1, 1.0, 0, 0, None, None, "", passes=False))
    assert not found.passes


def test_a_hanging_mass_softens_the_bent_arm_no_more_than_the_margin_assumes() -> None:
    for row in stiffness_rows(RigConfig()):
        if row.mass > 0.0:
            assert row.arm / row.observer >= min_stiffness_ratio(ROD, row.mass) - STIFFNESS_RANGE[0] + 1.0


@pytest.mark.parametrize("period", [0.01, 0.004])
@pytest.mark.parametrize("late", [0, 1, 3])
@pytest.mark.parametrize("ahead", [False, True])
def test_admitted_gains_keep_the_margin_for_every_mass_stiffness_and_delay(
    period: float, late: int, ahead: bool
) -> None:
    mass = default_tip_mass(ROD)
    gains = admitted_gains(ROD, period, -0.2, ASKED, RATES, late * period, mass)
    for load in (0.0, 0.2 * mass, mass):
        for stiffness in (min_stiffness_ratio(ROD, load), 1.15):
            for unknown in (0, 1):
                plant = UnknownPlant(load, stiffness, delay=late + unknown)
                more = replace(gains, integral=GAIN_MARGIN * gains.integral)
                assert growth(more, plant, period, late, ahead) < 0.0


def test_gains_are_never_raised_and_fall_with_mass_and_delay() -> None:
    def integral(delay: float, mass: float) -> float:
        return admitted_gains(ROD, 0.01, -0.2, ASKED, RATES, delay, mass).integral

    assert admitted_gains(ROD, 0.01, -0.2, ASKED, RATES, 0.0, 0.0) == ASKED
    assert ASKED.integral >= integral(0.0, 0.05) > integral(0.0, 0.1) > integral(0.03, 0.1) > 0.0


def test_the_papers_robot_is_stable_with_a_hundred_grams_by_default() -> None:
    assert default_tip_mass(ROD) == pytest.approx(0.1, rel=0.01)
    config = parse_config("[observer]\nintegral = 20.0\n", "eager")
    said = lowered(config, rod_from_section(config.rod, 0.01).parameters)
    assert said.startswith("observer.integral 20 -> ")
    assert "0 to 100 g" in said
    assert lowered(RigConfig(), rod_from_section(config.rod, 0.01).parameters) == ""


@pytest.mark.parametrize("mass", [0.02, 0.03, 0.05])
def test_a_configured_mass_on_the_tip_does_not_switch_the_observer_off(mass: float) -> None:
    bare, loaded = (
        admitted_gains(rod, 0.01, -0.2, ASKED, RATES, 0.0, 0.1) for rod in (ROD, replace(ROD, tip_mass=mass))
    )
    assert loaded.integral > 0.4 * bare.integral
    assert loaded.proportional > 0.4 * bare.proportional


def test_an_unknown_weight_beside_a_configured_mass_is_tolerated_and_found() -> None:
    """Run the closed loop on the full rod: 30 g known, 50 g not."""
    base = RigConfig()
    base = base.model_copy(update={"rod": base.rod.model_copy(update={"tip_mass": 0.03})})
    result = evaluate(base, Point("axes", "backstepping", "force", load_g=50.0), 0)
    assert result.mode == "tracking", result.reason
    assert result.steady_error_mm is not None
    assert result.steady_error_mm < 0.5
    assert result.force_error_n is not None
    assert result.force_error_n < 0.1 * 0.05 * 9.81


def test_a_robot_whose_tip_is_known_keeps_its_gains() -> None:
    config = parse_config("[observer]\ntip_mass_max = 0.0\n", "known")
    parameters = rod_from_section(config.rod, 0.01).parameters
    assert observer_gains(config, parameters).integral == config.observer.integral
    assert lowered(config, parameters) == ""
