"""Rod.predict says what the coming step will do, and how that answers to the tendons: the step itself is the judge."""

import numpy as np
import pytest

from tendond.model import Rod, RodParameters, RodState
from tests.unit.rod.rods import Array

PARAMETERS = RodParameters()
WAYS: Array = np.ascontiguousarray(np.linalg.pinv(np.array(PARAMETERS.tendon_positions).T).T)
"""Tensions per bending moment."""

FORCE = np.array([0.1, 0.05, -0.02])


def moving(rod: Rod, cycles: int) -> tuple[RodState, Array]:
    """A rod in motion in space, and the tensions that it moves under."""
    tensions = np.array([3.0, 1.0, 1.0, 2.0])
    state = rod.solve_static(tensions)
    for cycle in range(cycles):
        tensions = tensions + np.array([0.1, 0.2 * np.sin(cycle / 5.0), 0.02, 0.0])
        state = rod.step(state, tensions, tip_force=FORCE)
    return state, tensions


@pytest.mark.parametrize("jump", [0.0, 2.0])
def test_a_forecast_is_where_the_step_ends_also_after_a_jump_of_the_tension(jump: float) -> None:
    """Where it ends, as well as the step's own tolerance; the answers are those at the first guess of it."""
    rod = Rod(PARAMETERS, tolerance=1e-10)
    state, tensions = moving(rod, 12)
    tensions = tensions + np.array([jump, 0.0, 0.0, 0.0])
    said = rod.predict(state, tensions, WAYS, FORCE)
    tip = rod.tip(rod.step(state, tensions, tip_force=FORCE))
    # The guess of the step is further off after a jump, and so is what two corrections leave.
    near = 1e-9 if jump == 0.0 else 1e-6
    assert said.position == pytest.approx(tip.position, abs=near)
    assert said.velocity == pytest.approx(tip.velocity, abs=200.0 * near)
    assert said.direction == pytest.approx(tip.rotation[:, 2], abs=10.0 * near)
    # The answers are those at the guess: near the step's where the motion goes on as it was.
    small, rough = 1e-3, 1e-2 if jump == 0.0 else 5e-2
    for way in range(2):
        more, less = (
            rod.tip(rod.step(state, tensions + sign * small * WAYS[way], tip_force=FORCE)) for sign in (1.0, -1.0)
        )
        by_position = (more.position - less.position) / (2.0 * small)
        by_direction = (more.rotation[:, 2] - less.rotation[:, 2]) / (2.0 * small)
        size, turn = float(np.linalg.norm(by_position)), float(np.linalg.norm(by_direction))
        assert said.position_jacobian[:, way] == pytest.approx(by_position, abs=rough * size)
        assert said.direction_jacobian[:, way] == pytest.approx(by_direction, abs=rough * turn)


def test_a_forecast_leaves_the_state_as_it_was() -> None:
    rod = Rod(PARAMETERS)
    state, tensions = moving(rod, 3)
    before = rod.tip(state)
    rod.predict(state, tensions + 5.0, WAYS, FORCE)
    after = rod.tip(state)
    assert np.array_equal(before.position, after.position)
    assert np.array_equal(before.velocity, after.velocity)
