"""Each space scheme converges with the order that it is named for, and keeps R a rotation where it says so.

Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, section II.3: the error of a method of order p
falls with the p-th power of the step. So it does in motion, as each stage of each node keeps its own history in time.
"""

import numpy as np
import pytest

from tendond.model import Rod, RodState
from tendond.model.solver.schemes import SCHEMES
from tests.unit.rod.rods import PAPER, Array, External

COARSE_AND_FINE = {1: (97, 193), 4: (17, 33), 6: (9, 17)}
"""Nodes by order: few enough that truncation stands out of rounding, enough for its leading term to rule."""

LOADS = External(tip_force=(0.1, 0.2, -0.1), tip_moment=(0.02, -0.01, 0.03))


def moved(space: str, nodes: int, steps: int) -> tuple[Rod, RodState]:
    """A rod bent out of the plane by tendons and loads, and in motion after `steps` time steps."""
    rod = Rod(PAPER, space, nodes=nodes, tolerance=1e-11)
    state = rod.solve_static([8.0, 4.0, 1.0, 1.0], **LOADS)
    for _ in range(steps):
        state = rod.step(state, [16.0, 10.0, 1.0, 1.0], **LOADS)
    return rod, state


def quantities(space: str, nodes: int, steps: int) -> Array:
    """Position and tendon displacements [m], rotation, and velocity [m/s] of the tip, in one vector."""
    rod, state = moved(space, nodes, steps)
    tip = rod.tip(state)
    return np.concatenate([tip.position, rod.displacements(state), tip.rotation.ravel(), tip.velocity])


@pytest.mark.parametrize("space", list(SCHEMES))
@pytest.mark.parametrize("steps", [0, 5], ids=["static", "moving"])
def test_halving_the_step_divides_the_error_by_two_to_the_order(space: str, steps: int) -> None:
    exact = quantities("rk6", 65, steps)
    errors = [
        float(np.linalg.norm(quantities(space, nodes, steps) - exact))
        for nodes in COARSE_AND_FINE[SCHEMES[space].order]
    ]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(SCHEMES[space].order, abs=0.3)


def test_schemes_of_different_order_have_the_same_limit() -> None:
    """rk4 in 256 steps is off by 1e-4 m * (6 / 256)^4, about 1e-12 m, and its velocities by 1e-10 m/s."""
    assert np.max(np.abs(quantities("rk4", 257, 5) - quantities("rk6", 65, 5))) < 1e-9


@pytest.mark.parametrize("space", list(SCHEMES))
def test_rotations_stay_orthonormal_or_drift_by_a_truncation_error(space: str) -> None:
    scheme = SCHEMES[space]
    rod, state = moved(space, scheme.nodes, 5)
    drift = np.max(np.abs(state.rotations.transpose(0, 2, 1) @ state.rotations - np.eye(3)))
    if scheme.orthonormal:
        assert drift < 1e-9
    else:  # Euler adds |u ds|^2 at each of its steps: the paper's R leaves SO(3)
        u = state.levels[state.count % 3, :, 3:6]
        step = PAPER.length / (rod.nodes - 1)
        assert 0.0 < drift < 1.1 * step**2 * np.sum(u**2)


@pytest.mark.parametrize("space", list(SCHEMES))
def test_the_tableau_is_of_a_consistent_explicit_method(space: str) -> None:
    tableau, weights = SCHEMES[space].arrays()
    assert not np.any(np.triu(tableau))
    abscissae = tableau.sum(axis=1)
    for power in range(SCHEMES[space].order):  # the quadrature conditions: sum b c^k = 1 / (k + 1)
        assert weights @ abscissae**power == pytest.approx(1.0 / (power + 1), abs=1e-14)
