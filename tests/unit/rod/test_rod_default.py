"""The default scheme is good enough for control: the tip within 0.1 mm of the converged solution, up to half a turn."""

import math

import numpy as np
import pytest

from tendond.model import Rod, RodParameters
from tendond.model.solver.schemes import DEFAULT, SCHEMES
from tendond.offline.bench.schemes import STATIC_CASES

ENOUGH = 1e-4  # [m]

CONVERGED = Rod(RodParameters(), "rk4", nodes=101)
"""Compare with another scheme than the default; twice the nodes move its tip by less than a micrometre."""


@pytest.mark.parametrize("case", STATIC_CASES)
def test_statics_is_within_a_tenth_of_a_millimetre(case: str) -> None:
    loads = STATIC_CASES[case]
    rod = Rod(RodParameters())
    ours, exact = rod.solve_static(**loads), CONVERGED.solve_static(**loads)
    assert np.linalg.norm(rod.tip(ours).position - CONVERGED.tip(exact).position) < ENOUGH
    assert np.max(np.abs(rod.displacements(ours) - CONVERGED.displacements(exact))) < ENOUGH


@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.6, 0.8)])
def test_half_a_turn_in_any_plane_is_within_a_tenth_of_a_millimetre(direction: tuple[float, float]) -> None:
    """T r L / (E I) = pi without gravity bends the tip to point at where the base points from."""
    parameters = RodParameters(
        gravity=(0.0, 0.0, 0.0),
        tendon_positions=((0.02 * direction[0], 0.02 * direction[1]), (0.0, 0.0), (0.01, 0.0), (0.0, 0.01)),
    )
    tension = math.pi * parameters.youngs_modulus * parameters.second_moment / (0.02 * parameters.length)
    rod, fine = Rod(parameters), Rod(parameters, "rk4", nodes=101)
    ours, exact = (one.solve_static([tension, 0.0, 0.0, 0.0]) for one in (rod, fine))
    assert rod.tip(ours).rotation[2, 2] == pytest.approx(-1.0, abs=1e-3)
    assert np.linalg.norm(rod.tip(ours).position - fine.tip(exact).position) < ENOUGH
    for rotation in ours.rotations:
        assert np.max(np.abs(rotation.T @ rotation - np.eye(3))) < 1e-9


def test_a_violent_motion_is_within_a_tenth_of_a_millimetre() -> None:
    rod = Rod(RodParameters())
    ours, exact = rod.solve_static(), CONVERGED.solve_static()
    for step in range(80):
        tensions = (43.0, 0.0, 0.0, 0.0) if step < 40 else (20.0, 0.0, 15.0, 10.0)
        ours, exact = rod.step(ours, tensions), CONVERGED.step(exact, tensions)
        assert np.linalg.norm(rod.tip(ours).position - CONVERGED.tip(exact).position) < ENOUGH


def test_the_default_is_of_higher_order_than_the_papers_scheme() -> None:
    assert SCHEMES[DEFAULT].order > SCHEMES["euler"].order == 1
