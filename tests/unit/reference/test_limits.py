"""Limits by the number: what is let through, and which limit is named when one bites."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tendond.daemon.control.actuation import attainable, limit_displacement, limit_tension, net_tension
from tendond.schemas.config.control import LimitsSection

LIMITS = LimitsSection(
    tension_min=0.5,
    tension_max=50.0,
    tension_rate=1000.0,
    displacement_min=-0.1,
    displacement_max=0.2,
    displacement_rate=1.0,
)
PERIOD = 0.01


@pytest.mark.parametrize(
    ("wanted", "last", "allowed", "met"),
    [
        ((50.0,), (45.0,), (50.0,), ()),
        ((51.0,), (45.0,), (50.0,), ("tension max",)),
        ((0.5,), (1.0,), (0.5,), ()),
        ((0.4,), (1.0,), (0.5,), ("tension min",)),
        ((20.0,), (10.0,), (20.0,), ()),
        ((30.0,), (10.0,), (20.0,), ("tension rate",)),
        ((10.0,), (30.0,), (20.0,), ("tension rate",)),
        ((80.0,), (45.0,), (50.0,), ("tension rate", "tension max")),
        ((math.nan,), (10.0,), (10.0,), ("not finite",)),
        ((-math.inf,), (10.0,), (10.0,), ("not finite",)),
        ((51.0, math.nan, 30.0), (49.0, 7.0, 10.0), (50.0, 7.0, 20.0), ("not finite", "tension rate", "tension max")),
    ],
)
def test_a_tension_limit_is_named_when_it_bites_and_only_then(
    wanted: tuple[float, ...], last: tuple[float, ...], allowed: tuple[float, ...], met: tuple[str, ...]
) -> None:
    tension, names = limit_tension(LIMITS, PERIOD, np.array(wanted), np.array(last))
    assert tuple(tension.tolist()) == allowed
    assert names == met


@pytest.mark.parametrize(
    ("wanted", "last", "allowed", "met"),
    [
        (0.2, 0.195, 0.2, ()),
        (0.201, 0.195, 0.2, ("displacement",)),
        (-0.1, -0.095, -0.1, ()),
        (-0.101, -0.095, -0.1, ("displacement",)),
        (0.03, 0.0, 0.01, ("displacement rate",)),
        (-0.03, 0.0, -0.01, ("displacement rate",)),
        (0.5, 0.195, 0.2, ("displacement rate", "displacement")),
    ],
)
def test_a_displacement_limit_is_named_when_it_bites_and_only_then(
    wanted: float, last: float, allowed: float, met: tuple[str, ...]
) -> None:
    displacement, names = limit_displacement(LIMITS, PERIOD, np.array([wanted]), np.array([last]))
    assert displacement[0] == pytest.approx(allowed, abs=1e-15)
    assert names == met


def test_values_of_another_number_of_tendons_are_refused_and_not_cut() -> None:
    three, four = np.full(3, 0.01), np.full(4, 0.01)
    for limit in (limit_tension, limit_displacement):
        for wanted, last in ((three, four), (four, three)):
            with pytest.raises(ValueError, match="zip"):
                limit(LIMITS, PERIOD, wanted, last)
    for held, wanted, allowed in ((three, four, four), (four, three, four), (four, four, three)):
        with pytest.raises(ValueError, match="zip"):
            attainable(held, wanted, allowed)


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("argument", [0, 1, 2])
def test_nothing_is_feasible_of_a_step_that_is_not_finite(value: float, argument: int) -> None:
    values = [np.array([0.0, 0.0]), np.array([0.01, 0.02]), np.array([0.01, 0.02])]
    values[argument][1] = value
    assert attainable(*values) == 0.0


pairs = st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0))


@given(gain=pairs, missing=pairs, jacobian=pairs, gain_min=st.floats(0.5, 3.0), rate=st.floats(0.0, 1000.0))
def test_the_net_tension_is_the_inverse_paced_by_the_jacobian(
    gain: tuple[float, float],
    missing: tuple[float, float],
    jacobian: tuple[float, float],
    gain_min: float,
    rate: float,
) -> None:
    """b'm / max(b'b, kd b'D) where b'D > min |D|, else D'm / max(b'D, kd D'D); without D: b'm / max(b'b, min^2)."""
    b, m, d = np.array(gain), np.array(missing), np.array(jacobian) / 50.0
    plain = 3.0 + b @ m / max(b @ b, gain_min**2)
    assert net_tension(b, m, 3.0, gain_min) == pytest.approx(plain, rel=1e-9, abs=1e-9)
    assert net_tension(b, m, 3.0, gain_min, rate, np.zeros(2)) == pytest.approx(plain, rel=1e-9, abs=1e-9)
    along, size = float(b @ d), float(np.hypot(*d))
    if abs(along - gain_min * size) < 1e-9 * (1.0 + size) or size < 1e-6:
        return
    if along > gain_min * size:
        paced = 3.0 + b @ m / max(b @ b, rate * along)
        assert net_tension(b, m, 3.0, gain_min, 0.0, d) == net_tension(b, m, 3.0, gain_min, jacobian=d)
    elif rate * size > 1e-6:
        paced = 3.0 + d @ m / max(along, rate * size * size)
    else:
        return
    assert net_tension(b, m, 3.0, gain_min, rate, d) == pytest.approx(paced, rel=1e-9, abs=1e-9)
