"""All equilibria of a load, paths through folds, the balance of energy, and drawings."""

import math
from pathlib import Path

import numpy as np
import pytest

from tendond.model.errors import ParameterError
from tendond.model.strain import Robot, Section, StrainRod
from tendond.model.strain.analysis.balance import balance_of
from tendond.model.strain.analysis.equilibria import find_equilibria
from tendond.model.strain.analysis.load_path import follow_load
from tests.unit.strain.robots import paper

EI, LENGTH = 0.1, 0.5
CRITICAL = math.pi**2 * EI / (4.0 * LENGTH**2)
"""Euler's load of the clamped and free column [N]."""


def column(gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> StrainRod:
    """A strip that is soft about y only, so that it buckles in the plane x, z."""
    return StrainRod(Robot((Section(LENGTH, (20.0 * EI, EI), EI, 1e6, 0.01, 1e-6, bending_modes=5),), gravity=gravity))


def test_a_column_beyond_its_critical_load_has_three_equilibria_of_which_two_are_stable() -> None:
    """Euler's elastica: both buckled shapes, and the straight one; the next buckling is at nine times the load."""
    rod = column()
    loads = rod.loads(tip_force=(0.0, 0.0, -1.5 * CRITICAL))
    found = find_equilibria(rod, loads, starts=12)
    assert [one.stable for one in found] == [True, True, False]
    left, right, straight = (one.tip for one in found)
    assert abs(left[0]) == pytest.approx(abs(right[0]), rel=1e-6)
    assert left[0] * right[0] < 0.0
    assert straight[0] == pytest.approx(0.0, abs=1e-9)


def test_below_the_critical_load_there_is_one_equilibrium() -> None:
    rod = column()
    assert len(find_equilibria(rod, rod.loads(tip_force=(0.0, 0.0, -0.9 * CRITICAL)), starts=8)) == 1


def test_a_shape_that_is_bent_against_its_weight_is_followed_to_its_fold_and_beyond() -> None:
    """An imperfect column: the branch on the wrong side ends in a fold above the critical load, unstable behind it."""
    rod = column(gravity=(2.0, 0.0, 0.0))
    loads = rod.loads(tip_force=(0.0, 0.0, -1.5 * CRITICAL))
    against = min((one for one in find_equilibria(rod, loads) if one.stable), key=lambda one: one.tip[0])
    path = follow_load(rod, loads, against.state, first=1.0, last=0.0)
    assert len(path.folds) == 1
    fold = path.folds[0]
    turning = path.equilibria[fold]
    assert 1.0 < 1.5 * turning.share < 1.4
    assert abs(turning.stability) < 0.1
    assert all(one.stable for one in path.equilibria[: fold - 1])
    assert not any(one.stable for one in path.equilibria[fold + 2 :])


def test_a_load_without_folds_is_followed_to_its_end() -> None:
    rod = StrainRod(paper())
    loads = rod.loads([43.0, 0.0, 0.0, 0.0])
    path = follow_load(rod, loads, rod.solve_static(rod.loads()))
    assert path.complete
    assert path.folds == ()
    assert path.equilibria[-1].tip == pytest.approx(rod.tip(rod.solve_static(loads))[0], abs=1e-7)


def test_a_path_of_displacements_is_refused() -> None:
    rod = StrainRod(paper())
    with pytest.raises(ParameterError, match="follows tensions"):
        follow_load(rod, rod.loads(displacement=[0.01] * 4), rod.rest())


@pytest.mark.parametrize("damping", [0.0, 0.008])
def test_the_balance_of_a_pulled_robot_closes_with_what_damping_takes(damping: float) -> None:
    rod = StrainRod(paper(damping, drag=0.0), 0.002)
    loads = rod.loads([10.0, 0.0, 0.0, 0.0], tip_force=(0.0, 0.2, 0.0))
    state, work, lost = rod.solve_static(rod.loads()), 0.0, 0.0
    for _ in range(50):
        after = rod.step(state, loads)
        found = balance_of(rod, state, after, loads)
        assert found.before.total == pytest.approx(rod.energy(state), rel=1e-12)
        work, lost, state = work + found.tendons + found.forces, lost + found.lost, after
        assert found.lost > -1e-6 * abs(work)
    rate = state.rate @ rod.layout.damping @ state.rate
    assert work > 0.0
    assert lost < 0.2 * work if damping == 0.0 else lost > 0.2 * work
    assert (rate > 0.0) == (damping > 0.0)


def test_a_robot_is_drawn_and_shown(tmp_path: Path) -> None:
    pytest.importorskip("plotly")
    from tendond.offline.plots.robot import robot_figure, robot_view

    rod = StrainRod.from_config("rao-2021")
    states = [rod.rest(), rod.solve_static(rod.loads([2.0, 0.0, 0.0, 0.0, 3.0, 0.0]))]
    robot_figure(rod, states).savefig(tmp_path / "robot.png")
    assert (tmp_path / "robot.png").stat().st_size > 10_000
    view = robot_view(rod, states)
    assert [trace.name for trace in view.data] == ["backbone", "tendons", "bodies"]
    assert len(view.frames) == 2
    tip = np.array([view.data[0][axis][-1] for axis in "xyz"])
    assert tip == pytest.approx(1e3 * rod.tip(states[-1])[0])
