"""A rigid body on the tip: textbooks' frequencies and deflections, and what it is equivalent to."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from tendond.model import Rod, RodParameters
from tendond.model.errors import ParameterError
from tests.unit.rod.rods import PAPER, WEIGHTLESS, Array

DAMPING = 1.5e-3
"""Light damping [N m^2 s], and enough for single shooting at 2 ms."""


def frequency(parameters: RodParameters) -> float:
    """Natural frequency of a clamped beam with a mass on its end [Hz], mode 1, undamped.

    Blevins, Formulas for Natural Frequency and Mode Shape (1979), table 8-8:
    1 + cos b cosh b + (m / rhoA L) b (cos b sinh b - sin b cosh b) = 0.
    """
    ratio = parameters.tip_mass / (parameters.mass_per_length * parameters.length)

    def characteristic(b: float) -> float:
        inertia = ratio * b * (np.cos(b) * np.sinh(b) - np.sin(b) * np.cosh(b))
        return float(1.0 + np.cosh(b) * np.cos(b) + inertia)

    b = brentq(characteristic, 0.1, 1.8752)
    scale = parameters.bending_stiffness / (parameters.mass_per_length * parameters.length**4)
    return float(b**2 * np.sqrt(scale) / (2.0 * np.pi))


@pytest.mark.parametrize("mass", [0.0, 0.01, 0.05, 0.1])
def test_a_mass_on_the_tip_swings_at_the_textbooks_frequency(mass: float) -> None:
    damping = (DAMPING,) * 3
    parameters = replace(WEIGHTLESS, bending_damping=damping, drag=(0.0, 0.0, 0.0), tip_mass=mass)
    rod = Rod(parameters, time_step=0.002)
    state = rod.solve_static(tip_force=[0.02, 0.0, 0.0])
    tips = []
    for _ in range(1200):
        state = rod.step(state)
        tips.append(rod.tip(state).position[0])
    x = np.array(tips)
    rises = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    times = rises - x[rises] / (x[rises + 1] - x[rises])
    undamped = frequency(parameters)
    ratio = DAMPING / parameters.bending_stiffness * np.pi * undamped
    found = (len(times) - 1) / ((times[-1] - times[0]) * rod.time_step)
    assert found == pytest.approx(undamped * np.sqrt(1.0 - ratio**2), rel=1e-3)


def test_at_rest_a_body_is_its_weight() -> None:
    body, force = Rod(replace(PAPER, tip_mass=0.05)), Rod(PAPER)
    tensions = [12.0, 3.0, 0.0, 1.0]
    hung = body.tip(body.solve_static(tensions)).position
    pulled = force.tip(force.solve_static(tensions, tip_force=0.05 * np.array(PAPER.gravity))).position
    np.testing.assert_allclose(hung, pulled, atol=1e-9)


def test_a_body_beside_the_axis_turns_the_tip_as_its_weights_moment_does() -> None:
    offset = np.array([0.0, 0.03, 0.01])
    body = Rod(replace(PAPER, tip_mass=0.02, tip_offset=tuple(offset.tolist())))
    state = body.solve_static()
    tip = body.tip(state)
    weight = 0.02 * np.array(PAPER.gravity)
    plain = Rod(PAPER)
    moment: Array = np.cross(tip.rotation @ offset, weight)
    expected = plain.tip(plain.solve_static(tip_force=weight, tip_moment=moment))
    np.testing.assert_allclose(tip.position, expected.position, atol=1e-8)
    np.testing.assert_allclose(tip.rotation, expected.rotation, atol=1e-7)


def test_a_body_added_later_moves_as_one_that_was_configured() -> None:
    inertia, offset = (2e-6, 3e-6, 1e-6), (0.0, 0.0, 0.02)
    configured = Rod(replace(PAPER, tip_mass=0.03, tip_inertia=inertia, tip_offset=offset))
    later = Rod(PAPER)
    later.load_tip(0.03, inertia, offset)
    one, other = configured.solve_static(), later.solve_static()
    for _ in range(20):
        one, other = configured.step(one, [20.0, 0.0, 0.0, 0.0]), later.step(other, [20.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(configured.tip(one).position, later.tip(other).position)
    later.load_tip(0.0)
    assert later.tip(later.solve_static()).position == pytest.approx(Rod(PAPER).tip(Rod(PAPER).solve_static()).position)


def test_two_bodies_are_one_with_their_common_centre() -> None:
    together = Rod(replace(PAPER, tip_mass=0.02, tip_offset=(0.0, 0.0, 0.03)))
    together.load_tip(0.02, offset=(0.0, 0.0, -0.01))
    arm = 0.02**2 * 0.02 * 2.0
    one = Rod(replace(PAPER, tip_mass=0.04, tip_offset=(0.0, 0.0, 0.01), tip_inertia=(arm, arm, 0.0)))
    a, b = together.solve_static(), one.solve_static()
    for _ in range(15):
        a, b = together.step(a, [15.0, 0.0, 0.0, 5.0]), one.step(b, [15.0, 0.0, 0.0, 5.0])
    np.testing.assert_allclose(together.tip(a).position, one.tip(b).position, atol=1e-10)


def test_the_forecast_knows_of_the_body() -> None:
    rod = Rod(replace(PAPER, tip_mass=0.05))
    state = rod.solve_static([2.0, 2.0, 2.0, 2.0])
    tension = np.array([3.0, 2.0, 2.0, 2.0])
    for _ in range(5):
        state = rod.step(state, tension)
    ahead = rod.predict(state, tension, np.array([[1.0, 0.0, -1.0, 0.0], [0.0, 1.0, 0.0, -1.0]]), np.zeros(3))
    np.testing.assert_allclose(ahead.position, rod.tip(rod.step(state, tension)).position, atol=1e-6)


@pytest.mark.parametrize("mass", [-0.1, float("nan"), float("inf")])
def test_a_body_that_cannot_be_is_refused(mass: float) -> None:
    with pytest.raises(ParameterError):
        Rod(PAPER).load_tip(mass)
