"""Robots that single shooting does not solve, or solves wrongly: light wires, soft rods, folded starts, many turns.

Each stands for a kind; where there is no closed form, the reference is a planar elastica solved by scipy's collocation.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_bvp

from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.strain import Robot, Section, StrainRod, Tendon
from tendond.offline.bench.general_rod.survey import draw, run
from tests.unit.strain.robots import FOUR, nitinol, paper, with_modes

Array = NDArray[np.float64]

NO_GRAVITY = (0.0, 0.0, 0.0)


def elastica(load: float, weight: float) -> tuple[float, float]:
    """Tip (x, z) over length of an inextensible cantilever on z under P L^2/EI across its tip and w L^3/EI along it.

    theta'' = -(P + w (1 - s)) cos theta, theta(0) = 0, theta'(1) = 0; the load grows in steps, so that the shape is
    the one that it is bent to from straight.
    """
    s = np.linspace(0.0, 1.0, 101)
    y = np.zeros((4, s.size))
    for share in np.linspace(0.05, 1.0, 20):

        def slope(s: Array, y: Array, share: float = share) -> Array:
            angle, turn, _, _ = y
            force = share * (load + weight * (1.0 - s))
            return np.vstack([turn, -force * np.cos(angle), np.sin(angle), np.cos(angle)])

        found = solve_bvp(slope, lambda a, b: np.array([a[0], b[1], a[2], a[3]]), s, y, tol=1e-9, max_nodes=20000)
        assert found.success
        y = found.sol(s)
    return float(y[2, -1]), float(y[3, -1])


@pytest.mark.parametrize("load", [22.0, 24.0, 30.0])
def test_a_load_across_the_tip_ends_in_the_elastica_and_not_in_a_fold(load: float) -> None:
    rod = StrainRod(with_modes(paper(gravity=NO_GRAVITY), 8))
    force = load * rod.robot.sections[0].bending_stiffness[0] / 0.5**2
    tip, _ = rod.tip(rod.solve_static(rod.loads(tip_force=(force, 0.0, 0.0))))
    x, z = elastica(load, 0.0)
    assert tip / 0.5 == pytest.approx([x, 0.0, z], abs=1e-4)


def silicone(bending_modes: int, damping: float = 0.0, length: float = 0.3) -> Robot:
    """A soft rod of 10 mm, clamped level; `damping` [s] of its bending stiffness."""
    plain = Section.round(length, 5e-3, 1e6, 1000.0, bending_modes=bending_modes)
    section = replace(plain, bending_damping=(damping * plain.bending_stiffness[0],) * 3)
    return Robot((section,), tuple(Tendon(length, (0.2 * x, 0.2 * y)) for x, y in FOUR), (), (-9.81, 0.0, 0.0))


@pytest.mark.parametrize(("modes", "bound"), [(4, 2e-3), (8, 1e-4)])
def test_a_soft_rod_hangs_from_its_base_as_the_elastica_under_its_weight(modes: int, bound: float) -> None:
    robot = silicone(modes)
    robot = replace(robot, sections=(replace(robot.sections[0], stretch_modes=0),))
    rod, section = StrainRod(robot), robot.sections[0]
    weight = 9.81 * section.mass_per_length * 0.3**3 / section.bending_stiffness[0]
    assert weight == pytest.approx(42.4, abs=0.1)
    x, z = elastica(0.0, weight)
    tip, _ = rod.tip(rod.solve_static(rod.loads()))
    assert tip / 0.3 == pytest.approx([-x, 0.0, z], abs=bound)


@pytest.mark.parametrize("radius", [0.25e-3, 0.15e-3, 0.1e-3])
def test_a_thin_wire_is_solved_as_accurately_as_a_thick_one(radius: float) -> None:
    """A tolerance in newtons leaves a wire of 0.2 mm 2 % L off; the shooting rod's is in proportion to EI, as this."""
    rod = StrainRod(nitinol(radius=radius))
    places = tuple((0.1 * x, 0.1 * y) for x, y in FOUR)
    shooting = Rod(
        RodParameters(
            length=0.3,
            radius=radius,
            youngs_modulus=60e9,
            density=6450.0,
            tendon_positions=places,
            gravity=(-9.81, 0, 0),
        ),
        "rk6",
        21,
    )
    stiffness = rod.robot.sections[0].bending_stiffness[0]
    rng = np.random.default_rng(1)
    for _ in range(20):
        tension = rng.uniform(0.0, math.radians(90.0) * stiffness / 0.3 / 0.002, 4)
        force = rng.normal(size=3) * stiffness / 0.3**2
        tip, _ = rod.tip(rod.solve_static(rod.loads(tension, tip_force=force)))
        assert tip == pytest.approx(
            shooting.tip(shooting.solve_static(tension, tip_force=force)).position, abs=1e-3 * 0.3
        )


@pytest.mark.parametrize("time_step", [0.0005, 0.001, 0.01])
def test_a_light_wire_under_a_steady_load_stays_at_rest(time_step: float) -> None:
    rod = StrainRod(paper(damping=1e-4), time_step)
    loads = rod.loads([5.0, 0.0, 0.0, 0.0])
    state = rod.solve_static(loads)
    start, _ = rod.tip(state)
    for _ in range(500):
        state = rod.step(state, loads)
    assert np.linalg.norm(rod.tip(state)[0] - start) < 1e-9


@pytest.mark.parametrize(("length", "time_step"), [(0.3, 0.001), (0.3, 0.005), (0.1, 0.001), (0.1, 0.01)])
def test_a_soft_rod_follows_a_smooth_pull_at_any_step(length: float, time_step: float) -> None:
    """A pull to 90 degrees and back in a second, within 0.5 % L of a converged motion, under the steps' mean loads."""
    tips = []
    for modes, step in ((4, time_step), (8, 0.00025)):
        rod = StrainRod(silicone(modes, 0.0536, length), step)
        full = math.radians(45.0) * rod.robot.sections[0].bending_stiffness[0] / length / 0.004
        state, found = rod.solve_static(rod.loads()), []
        for k in range(round(1.0 / step)):
            pull = full * (1.0 - math.cos(2.0 * math.pi * (k + 0.5) * step))
            state = rod.step(state, rod.loads([pull, 0.0, 0.0, 0.0]))
            found.append(rod.tip(state)[0])
            assert state.damped == 0
        tips.append(np.array(found))
    every = round(time_step / 0.00025)
    assert np.linalg.norm(tips[0] - tips[1][every - 1 :: every], axis=1).max() < 5e-3 * length


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_moment_on_the_tip_coils_the_rod_to_whole_turns(turns: int) -> None:
    rod = StrainRod(paper(gravity=NO_GRAVITY))
    moment = 2.0 * math.pi * turns * rod.robot.sections[0].bending_stiffness[0] / 0.5
    loads = rod.loads(wrenches=[(0.5, NO_GRAVITY, (0.0, moment, 0.0))])
    tip, rotation = rod.tip(rod.solve_static(loads))
    assert tip == pytest.approx(np.zeros(3), abs=1e-9)
    assert rotation == pytest.approx(np.eye(3), abs=1e-9)


@pytest.mark.parametrize("degrees", [180.0, 360.0, 540.0, 720.0])
def test_one_tendon_coils_the_rod_to_the_exact_arc(degrees: float) -> None:
    rod = StrainRod(paper(gravity=NO_GRAVITY))
    section = rod.robot.sections[0]
    tension = math.radians(degrees) * section.bending_stiffness[0] / 0.5 / 0.02
    stretch = 1.0 - tension / section.axial_stiffness
    curvature = 0.02 * tension / section.bending_stiffness[0]
    arc = [1.0 - math.cos(0.5 * curvature), 0.0, math.sin(0.5 * curvature)]
    tip, _ = rod.tip(rod.solve_static(rod.loads([tension, 0.0, 0.0, 0.0])))
    assert tip == pytest.approx(stretch / curvature * np.array(arc), abs=5e-6)


@pytest.mark.parametrize("number", [7459, 7777, 9466, 9932, 23923, 51814])
def test_rests_of_soft_coils_that_rounding_hides_are_found(number: int) -> None:
    """Draws of `tendond bench rod --survey` whose energy is flat to the last digits long before Newton's step is."""
    assert run(draw(number)).failed == ""


@pytest.mark.parametrize("number", [21526, 24088, 64108])
def test_soft_arms_gain_no_energy_in_steps_far_shorter_than_their_periods(number: int) -> None:
    """Draws in which what Newton's tolerance leaves works against large forces on moves of 1e-5 rad."""
    assert run(draw(number)).failed == ""
