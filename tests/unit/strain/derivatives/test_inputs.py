"""Derivatives of tip and tendons by what acts during a step, against those of the whole linear model."""

from collections.abc import Callable

import numpy as np
import pytest

from tendond.model.strain import Robot, StrainRod
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.stepping.scratch import Loads
from tests.unit.strain.derivatives.programs import driven, pulled, pushed, two_sections
from tests.unit.strain.robots import paper


@pytest.mark.parametrize(
    ("robot", "time_step", "program", "bound"),
    [
        (lambda: paper(), 0.01, pulled, 1e-4),
        (two_sections, 0.01, pushed, 2e-3),
        (lambda: paper(damping=1e-3, drag=50.0), 0.005, driven, 1e-2),
        (lambda: paper(damping=0.0, drag=0.0), 0.02, lambda rod, k: rod.loads([200.0, 0.0, 0.0, 0.0]), 1e-2),
    ],
    ids=["tensions", "two sections with loads", "displacements with drag", "split"],
)
def test_what_acts_during_a_step_moves_tip_and_tendons_as_the_whole_linear_model_says(
    robot: Callable[[], Robot], time_step: float, program: Callable[[StrainRod, int], Loads], bound: float
) -> None:
    """Newton's matrix leaves out that axes turn with the rod, those of drag above all. Calls in turn share arrays."""
    rod = StrainRod(robot(), time_step)
    linear, both = Linearisation(rod), Linearisation(rod)
    state = rod.rest()
    for k in range(3):
        loads = program(rod, k)
        whole = linear.step(state, loads)
        c = linear.outputs(whole.state)
        found = both.inputs(state, loads)
        expected = (c.position @ whole.b, c.rotation @ whole.b, c.displacement @ whole.b, c.position @ whole.by_force)
        ours = (found.position, found.rotation, found.displacement, found.by_force)
        near = bound if whole.analytic else 1e-9  # what is split is differenced alike
        for mine, theirs in zip(ours, expected, strict=True):
            assert mine == pytest.approx(theirs, abs=near * max(float(np.abs(theirs).max()), 1e-12))
        assert found.analytic == whole.analytic
        after = both.step(state, loads)
        assert np.array_equal(found.state.strain, whole.state.strain)
        assert np.array_equal(after.state.rate, whole.state.rate)
        assert after.a == pytest.approx(whole.a, rel=1e-9, abs=1e-9 * float(np.abs(whole.a).max()))
        state = whole.state
