"""Bounds of the observer's pull, and the removal of errors by the law in space."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws import sensitivity
from tendond.daemon.control.laws.law import SpatialObservation
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.control.tasks.observation import Prediction
from tendond.model.estimation.compliance import tip_compliance
from tendond.model.estimation.observer import observe, start_observer
from tendond.model.estimation.observer_gains import (
    INNOVATION_LIMIT,
    LATERAL_VARIANCE,
    PULL_MAX,
    UNOBSERVABLE,
    ObserverGains,
)
from tendond.model.rods.selection import rod_from_section
from tendond.model.tendons.allocation import Allocation
from tendond.schemas.config.rig import parse_config
from tendond.schemas.config.robot import RodSection
from tendond.schemas.record import CycleInputs
from tests.unit.control.cycles import pose


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, -0.8)])
def test_the_pull_on_the_model_is_bounded_by_four_times_the_largest_estimated_force(
    direction: tuple[float, ...],
) -> None:
    """A tip 0.2 m from the model's asks for newtons; 0.05 N are the largest force that may be estimated."""
    setup = CycleSetup.from_config(parse_config("[observer]\nforce_max = 0.05\n", "test"))
    state = initial_state(setup)
    away = tuple((state.tip.position + 0.2 * np.array(direction)).tolist())
    pulls = []
    for seq in range(1, 8):
        state, _, record = step(setup, state, CycleInputs(pose=pose(seq, away)))
        pulls.append(np.linalg.norm(record.observer.pull))
        assert np.linalg.norm(record.observer.force) <= 0.05 + 1e-12
    assert max(pulls) == pytest.approx(0.2)  # the bound is met


def test_the_law_in_space_lets_an_error_decay_at_two_rates_whatever_it_is_doing() -> None:
    """e(k+1) = (a + b) e(k) - a b e(k-1), a and b the decay of `rate` and of `smoothing` in a cycle."""
    parameters = sensitivity.Parameters()
    period, allocation = 0.01, Allocation(RodSection().tendon_positions, 1.0, 60.0)
    before, now = np.array([0.004, -0.002, 0.001]), np.array([0.003, 0.001, -0.002])
    ahead = np.array([0.3, 0.1, 0.2])
    zero = np.zeros(3)
    observation = SpatialObservation(
        position=zero,
        velocity=-(now - before) / period,
        target=now,
        target_velocity=zero,
        tension=np.full(4, 5.0),
        period=period,
        prediction=Prediction(ahead, np.eye(3)[:, :2], ahead, None, allocation),
    )
    a, b = (math.exp(-rate * period) for rate in (parameters.rate, parameters.smoothing))
    terms = sensitivity.decide(parameters, observation).terms
    assert isinstance(terms, sensitivity.Terms)
    assert terms.asked == pytest.approx(-((a + b) * now - a * b * before), abs=1e-15)


GAINS = ObserverGains(
    kind="force", period=0.01, delay=0.013, integral=12.0, proportional=0.4, derivative=0.02, noise_floor=2e-3,
    noise_share=0.1, innovation_time=0.05, force_max=3.0, offset_gain=0.2,
)  # fmt: skip
BENT = [20.0, 6.0, 0.0, 0.0]
"""Tensions [N] under which the rod leaves the plane."""


def documented_gain(positions: np.ndarray, length: float, stiffness: float, gravity: np.ndarray) -> np.ndarray:
    """C^+ = P C (C P C + r 1)^-1 with C by the unit-load method, trapezium rule over the nodes [N/m], shape (3, 3)."""
    compliance = np.zeros((3, 3))
    for k, position in enumerate(positions):
        arm = positions[-1] - position
        share = 0.5 if k in (0, len(positions) - 1) else 1.0
        compliance += share * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    compliance *= length / (len(positions) - 1) / stiffness
    size = np.linalg.norm(gravity)
    down = gravity / size if size else gravity
    prior = LATERAL_VARIANCE * np.eye(3) + (1.0 - LATERAL_VARIANCE) * np.outer(down, down) if size else np.eye(3)
    floor = (UNOBSERVABLE * 0.5 * np.trace(compliance)) ** 2
    return np.asarray(prior @ compliance @ np.linalg.inv(compliance @ prior @ compliance + floor * np.eye(3)))


@pytest.mark.parametrize("gravity", [(-9.81, 0.0, 0.0), (3.0, -4.0, 8.0), (0.0, 0.0, 0.0)])
@pytest.mark.parametrize("size", [1e-4, 5e-3, 0.2], ids=["as noise", "small", "an impact"])
def test_force_and_pull_follow_the_documented_equations(gravity: tuple[float, float, float], size: float) -> None:
    """Two cycles against them in numpy: e, m, F and pull, with a delay of one period and three tenths."""
    rod = rod_from_section(RodSection(gravity=gravity), GAINS.period)
    model = rod.solve_static(BENT)
    spring = documented_gain(
        rod.node_positions(model), rod.parameters.length, rod.parameters.bending_stiffness, np.array(gravity)
    )
    tips = [np.array([0.1, 0.02, 0.45]) + 1e-3 * k * np.array([1.0, -2.0, 0.5]) for k in range(3)]
    state = start_observer(GAINS, tips[0])
    past = [tips[0]] * 3
    force, mean = np.zeros(3), np.zeros(3)
    for k, direction in ((1, (0.6, 0.0, -0.8)), (2, (0.48, 0.6, -0.64))):
        past = [*past[1:], tips[k]]
        measured = 0.7 * past[-2] + 0.3 * past[-3] + size * np.array(direction)
        e = size * np.array(direction)
        mean = mean + 0.2 * (e - mean)  # period / innovation_time
        weight = 0.1 + 0.9 * (mean @ mean) / (mean @ mean + 2e-3**2)
        limit = min(1.0, INNOVATION_LIMIT * rod.parameters.length / size)
        force = bounded(force + weight * limit * 12.0 * 0.01 * spring @ e, 3.0)
        pull = bounded(weight * spring @ (0.4 * e + 0.02 / 0.05 * (e - mean)), PULL_MAX * 3.0)
        state = observe(GAINS, state, rod, model, tips[k], measured)
        np.testing.assert_allclose(state.innovation, e, atol=1e-14)
        np.testing.assert_allclose(state.mean, mean, atol=1e-14)
        np.testing.assert_allclose(state.force, force, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(state.pull, pull, rtol=1e-9, atol=1e-15)
        np.testing.assert_allclose(state.tip_force, force + pull, rtol=1e-9, atol=1e-15)
        assert not state.offset.any()


def bounded(force: np.ndarray, largest: float) -> np.ndarray:
    return np.asarray(force * min(1.0, largest / max(float(np.linalg.norm(force)), 1e-300)))


def test_the_compliance_is_the_unit_load_integral_over_a_bent_rod() -> None:
    """A straight cantilever gives L^3 / (3 EI) across itself and nothing along itself (Timoshenko).

    The trapezium rule with n intervals integrates its square to 1 + 1 / (2 n^2) times that.
    """
    rod = rod_from_section(RodSection(gravity=(0.0, 0.0, 0.0)), GAINS.period)
    length, stiffness = rod.parameters.length, rod.parameters.bending_stiffness
    start = rod.solve_static([0.0] * 4)
    intervals = len(rod.node_positions(start)) - 1
    across = length**3 / (3.0 * stiffness) * (1.0 + 0.5 / intervals**2)
    np.testing.assert_allclose(tip_compliance(rod, start), np.diag([across, across, 0.0]), atol=1e-9 * across)
    model = rod.solve_static(BENT)
    bent = tip_compliance(rod, model)
    positions = rod.node_positions(model)
    arms = positions[-1] - positions
    whole = np.einsum("ki,ki->k", arms, arms)[:, None, None] * np.eye(3) - np.einsum("ki,kj->kij", arms, arms)
    expected = np.trapezoid(whole, dx=length / (len(positions) - 1), axis=0) / stiffness
    np.testing.assert_allclose(bent, expected, rtol=1e-12, atol=1e-15)


def test_the_offset_is_a_low_pass_of_the_innovation_and_pulls_nothing() -> None:
    gains = replace(GAINS, kind="offset", delay=0.0)
    rod = rod_from_section(RodSection(), gains.period)
    model, tip = rod.solve_static(BENT), np.array([0.1, 0.02, 0.45])
    state, offset, e = start_observer(gains, tip), np.zeros(3), np.array([0.003, -0.002, 0.001])
    for _ in range(3):
        state = observe(gains, state, rod, model, tip, tip + e)
        offset = offset + 0.2 * (e - offset)
        np.testing.assert_allclose(state.offset, offset, atol=1e-15)
        assert not state.tip_force.any()


def test_a_cycle_without_a_measurement_keeps_all_but_the_pull_and_remembers_the_models_tip() -> None:
    rod = rod_from_section(RodSection(), GAINS.period)
    model, tip = rod.solve_static(BENT), np.array([0.1, 0.02, 0.45])
    pushed = np.array([0.05, 0.0, 0.0])
    start = start_observer(GAINS, tip, pushed)
    np.testing.assert_array_equal(start.tip_force, pushed)
    before = observe(GAINS, start, rod, model, tip, tip + 0.01)
    after = observe(GAINS, before, rod, model, tip + 0.002, None)
    for kept in ("innovation", "mean", "offset", "force"):
        np.testing.assert_array_equal(getattr(after, kept), getattr(before, kept))
    assert before.pull.any()
    assert not after.pull.any()
    np.testing.assert_array_equal(after.past, [tip, tip, tip + 0.002])
