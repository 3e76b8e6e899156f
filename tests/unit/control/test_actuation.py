"""The one place that bounds a command."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tendond.daemon.control.actuation import (
    attainable,
    follow,
    lag_factor_of,
    lead,
    limit_displacement,
    limit_tension,
    net_tension,
    share,
)
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

LIMITS = LimitsSection(tension_min=0.5, tension_max=50.0, tension_rate=1000.0, displacement_rate=1.0)
PERIOD = 0.01

anything = arrays(np.float64, 4, elements=st.floats(allow_nan=True, allow_infinity=True))
inside = arrays(np.float64, 4, elements=st.floats(0.5, 50.0))


@given(wanted=anything, last=inside)
def test_a_tension_is_finite_and_within_its_bounds_and_rate_whatever_is_wanted(
    wanted: np.ndarray, last: np.ndarray
) -> None:
    tension, met = limit_tension(LIMITS, PERIOD, wanted, last)
    assert np.all(np.isfinite(tension))
    assert np.all((tension >= 0.5) & (tension <= 50.0))
    assert np.all(np.abs(tension - last) <= 10.0 + 1e-9)
    assert bool(met) == bool(np.any(tension != wanted))


@given(
    wanted=arrays(np.float64, 4, elements=st.floats(-1.0, 1.0)),
    last=arrays(np.float64, 4, elements=st.floats(-0.1, 0.1)),
)
def test_a_displacement_is_within_its_range_and_rate(wanted: np.ndarray, last: np.ndarray) -> None:
    displacement, met = limit_displacement(LIMITS, PERIOD, wanted, last)
    assert np.all(np.abs(displacement - last) <= 0.01 + 1e-12)
    assert np.all((displacement >= LIMITS.displacement_min) & (displacement <= LIMITS.displacement_max))
    assert bool(met) == bool(np.any(displacement != wanted))


def test_the_inverse_of_b_c_is_bounded_near_the_straight_rod() -> None:
    missing = np.array([100.0, 0.0])
    assert net_tension(np.array([20.0, 0.0]), missing, 3.0, 1.0) == pytest.approx(3.0 + 5.0)
    assert net_tension(np.array([0.01, 0.0]), missing, 3.0, 1.0) == pytest.approx(3.0 + 1.0)
    assert net_tension(np.zeros(2), missing, 3.0, 1.0) == 3.0


def test_with_the_tips_jacobian_the_inverse_never_points_against_it_and_is_paced_by_it() -> None:
    missing, jacobian = np.array([100.0, 0.0]), np.array([0.05, 0.0])
    bent = net_tension(np.array([200.0, 0.0]), missing, 3.0, 1.0, 1000.0, jacobian)
    assert bent == pytest.approx(3.0 + 100.0 / 200.0)  # b_c^+ takes less of the error away: the paper's own
    paced = 3.0 + 100.0 / 1000.0 / 0.05
    for gain in (20.0, 1.1, 0.9, 0.0, -0.9, -20.0):
        net = net_tension(np.array([gain, 0.0]), missing, 3.0, 1.0, 1000.0, jacobian)
        assert net == pytest.approx(paced), gain
    assert net_tension(np.array([20.0, 0.0]), missing, 3.0, 1.0, 1000.0, np.zeros(2)) == pytest.approx(8.0)


@given(net=st.floats(-50.0, 50.0), tension_min=st.floats(0.0, 5.0))
def test_a_pair_has_its_difference_and_its_min_tension(net: float, tension_min: float) -> None:
    tension = share(4, 0, 2, net, tension_min)
    assert tension[0] - tension[2] == pytest.approx(net)
    assert min(tension[0], tension[2]) == pytest.approx(tension_min)
    assert tension[1] == tension[3] == 0.0


@given(last=st.floats(0.0, 60.0), wanted=st.floats(0.0, 60.0), lag=st.floats(0.0, 0.1))
def test_leading_a_lag_brings_the_actuator_where_it_is_wanted(last: float, wanted: float, lag: float) -> None:
    lag_factor = lag_factor_of(lag, PERIOD)
    command = lead(np.array([wanted]), np.array([last]), lag_factor)
    assert follow(command, np.array([last]), lag_factor)[0] == pytest.approx(wanted, abs=1e-9)


def test_a_lag_is_the_step_response_of_its_time_constant() -> None:
    assert lag_factor_of(0.0, PERIOD) == 0.0
    assert lag_factor_of(PERIOD / math.log(2.0), PERIOD) == pytest.approx(0.5)


def test_the_feasible_part_of_a_step_is_its_smallest_over_the_tendons() -> None:
    held, wanted = np.array([0.0, 0.0, 0.0]), np.array([0.02, -0.02, 0.0])
    assert attainable(held, wanted, wanted) == 1.0
    assert attainable(held, wanted, np.array([0.01, -0.02, 0.0])) == pytest.approx(0.5)
    assert attainable(held, wanted, np.array([0.01, -0.005, 0.0])) == pytest.approx(0.25)
    assert attainable(held, held, np.array([0.01, 0.0, 0.0])) == 0.0


def test_a_slow_servo_slows_the_bend_down_and_does_not_stop_it() -> None:
    """85 mm/s is the XL430 at its real speed on a spool of 15 mm: 58 mm take 0.68 s."""
    elastic = "tendon_stiffness = 2.0e4\n"
    config = parse_config(
        f"[rod]\n{elastic}[simulator.rod]\n{elastic}[limits]\ndisplacement_rate = 0.085\nslack = 0.002\n"
        '[simulator]\ndrive = "displacement"\n[simulator.servo]\nrate = 0.085\n',
        "test",
    )
    records = list(closed_loop(config, 300, {5: ControlAction.ARM}))
    displacements = np.array([record.command.displacement for record in records if record.command.armed])
    assert np.max(np.abs(np.diff(displacements, axis=0))) <= 0.085 * PERIOD + 1e-12
    assert records[-1].mode is Mode.TRACKING
    assert records[-1].measured is not None
    assert records[-1].measured[0] == pytest.approx(0.34, abs=1e-3)
    limited = sum("displacement rate" in record.limited for record in records)
    assert 55 <= limited <= 90


@pytest.mark.parametrize("tension_min", [0.5, 40.0])
def test_the_min_tension_is_reached_at_the_rate_and_not_at_once(tension_min: float) -> None:
    config = parse_config(f"[limits]\ntension_min = {tension_min}\ntension_rate = 100.0\n", "test")
    records = list(closed_loop(config, 100, {5: ControlAction.ARM}))
    tensions = np.array([record.command.tension for record in records])
    assert np.max(np.abs(np.diff(tensions, axis=0))) <= 100.0 * PERIOD + 1e-9
    assert np.min(tensions[60]) == pytest.approx(tension_min)
    assert records[-1].mode is Mode.TRACKING


def test_other_tendons_at_their_min_tension_are_no_fault() -> None:
    config = parse_config("[limits]\ntension_min = 0.5\n", "test")
    *_, last = closed_loop(config, 300, {5: ControlAction.ARM})
    assert (last.mode, last.limited) == (Mode.TRACKING, ("tension min",))
