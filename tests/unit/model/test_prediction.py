"""Rod.predict gives the tip after the coming step and its jacobian by the tendons, as the step itself does."""

import numpy as np
import pytest

from tendond.model import Rod, RodParameters, RodState
from tests.unit.rod.rods import Array

PARAMETERS = RodParameters()
INPUTS: Array = np.ascontiguousarray(np.linalg.pinv(np.array(PARAMETERS.tendon_positions).T).T)
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
def test_a_prediction_is_where_the_step_ends_also_after_a_jump_of_the_tension(jump: float) -> None:
    """Tip at the end of the step, within the step's own tolerance; the jacobians are those at its first guess."""
    rod = Rod(PARAMETERS, tolerance=1e-10)
    state, tensions = moving(rod, 12)
    tensions = tensions + np.array([jump, 0.0, 0.0, 0.0])
    predicted = rod.predict(state, tensions, INPUTS, FORCE)
    tip = rod.tip(rod.step(state, tensions, tip_force=FORCE))
    # The guess of the step is further off after a jump, and so is what two corrections leave.
    close = 1e-9 if jump == 0.0 else 1e-6
    assert predicted.position == pytest.approx(tip.position, abs=close)
    assert predicted.velocity == pytest.approx(tip.velocity, abs=200.0 * close)
    assert predicted.direction == pytest.approx(tip.rotation[:, 2], abs=10.0 * close)
    # The jacobians are those at the guess: close to the step's where the motion continues.
    small, rough = 1e-3, 1e-2 if jump == 0.0 else 5e-2
    for column in range(2):
        more, less = (
            rod.tip(rod.step(state, tensions + sign * small * INPUTS[column], tip_force=FORCE)) for sign in (1.0, -1.0)
        )
        by_position = (more.position - less.position) / (2.0 * small)
        by_direction = (more.rotation[:, 2] - less.rotation[:, 2]) / (2.0 * small)
        size, turn = float(np.linalg.norm(by_position)), float(np.linalg.norm(by_direction))
        assert predicted.position_jacobian[:, column] == pytest.approx(by_position, abs=rough * size)
        assert predicted.direction_jacobian[:, column] == pytest.approx(by_direction, abs=rough * turn)


def test_a_prediction_leaves_the_state_as_it_was() -> None:
    rod = Rod(PARAMETERS)
    state, tensions = moving(rod, 3)
    before = rod.tip(state)
    rod.predict(state, tensions + 5.0, INPUTS, FORCE)
    after = rod.tip(state)
    assert np.array_equal(before.position, after.position)
    assert np.array_equal(before.velocity, after.velocity)
