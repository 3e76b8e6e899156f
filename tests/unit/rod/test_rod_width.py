"""The kernels serve every number of tendons up to their width: what a rod has not costs nothing and changes nothing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.rod.discretisation import kernel_width
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tests.unit.rod.rods import PAPER

POSITIONS = ((0.02, 0.0), (-0.008, 0.015), (-0.012, -0.011), (0.005, 0.018))


def rod_of(count: int) -> Rod:
    return Rod(replace(PAPER, tendon_positions=POSITIONS[:count]), "euler", nodes=10)


def padded(values: list[float], count: int) -> NDArray[np.float64]:
    return np.array(values + [0.0] * (count - len(values)))


def moved(count: int, tensions: list[float]) -> tuple[Rod, RodState]:
    """A rod after ten steps, under the first tendons' tensions, all others slack."""
    rod = rod_of(count)
    state = rod.solve_static(padded([1.0] * len(tensions), count))
    for _ in range(10):
        state = rod.step(state, padded(tensions, count))
    return rod, state


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_rod_with_fewer_tendons_is_the_one_whose_others_are_slack(count: int) -> None:
    tensions = [5.0, 2.0, 3.5][:count]
    few, own = moved(count, tensions)
    four, slack = moved(4, tensions)
    assert own.shape.tobytes() == slack.shape.tobytes()
    assert few.displacements(own).tobytes() == four.displacements(slack)[:count].tobytes()
    tip, other = few.tip(own), four.tip(slack)
    assert tip.input_gain.shape == (3, count)
    np.testing.assert_array_equal(tip.input_gain, other.input_gain[:, :count])
    jacobians, others = few.sensitivity(own), four.sensitivity(slack)
    np.testing.assert_allclose(jacobians.position_actuation, others.position_actuation[:, :count], rtol=1e-9)


@pytest.mark.parametrize("count", [1, 3])
def test_strings_pull_alike_beside_tendons_that_are_far_from_taut(count: int) -> None:
    """Displacement-driven: the tendons that the rod has not are no unknowns."""
    few, four = rod_of(count), rod_of(4)
    ends = [0.012, 0.004, 0.006][:count]
    own = few.solve_static(displacements=ends)
    slack = four.solve_static(displacements=ends + [-0.2] * (4 - count))
    assert own.tensions.shape == (count,)
    np.testing.assert_allclose(own.tensions, slack.tensions[:count], rtol=1e-7)
    np.testing.assert_allclose(own.shape, slack.shape, atol=1e-9)


def test_rods_of_one_to_four_tendons_have_the_same_kernels() -> None:
    assert [kernel_width(count) for count in (1, 3, 4, 5, 8, 9, 16, 17)] == [4, 4, 4, 8, 8, 16, 16, 17]
    called = {type(rod_of(count)._data.x) for count in (1, 2, 3, 4)}, {len(rod_of(n)._data.x) for n in (1, 2, 3, 4)}
    assert called == ({tuple}, {4})
