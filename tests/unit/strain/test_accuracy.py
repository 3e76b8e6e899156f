"""Estimates of the tip's error against the error itself, and modes and steps that keep a tolerance."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain import Robot, StrainRod
from tendond.model.strain.analysis.accuracy import TipError, refine, tip_error
from tendond.model.strain.stepping.scratch import Loads
from tests.unit.strain.robots import nitinol, paper, with_modes

Program = Callable[[StrainRod, float], Loads]


def pulled(degrees: float) -> Program:
    """The first tendon from nothing to a bend, in one step."""

    def program(rod: StrainRod, t: float) -> Loads:
        section, route = rod.robot.sections[0], rod.robot.tendons[0].at(0.0)
        tension = math.radians(degrees) * section.bending_stiffness[0] / (section.length * route[0])
        return rod.loads([tension if t > 0.0 else 0.0, 0.0, 0.0, 0.0])

    return program


def pushed(force: float) -> Program:
    """A push across the tip that lasts for 20 ms."""
    return lambda rod, t: rod.loads(tip_force=(0.0, force if 0.0 < t < 0.0201 else 0.0, 0.0))


def motion(
    robot: Robot, time_step: float, duration: float, program: Program
) -> tuple[NDArray[np.float64], list[TipError]]:
    rod = StrainRod(robot, time_step)
    state = rod.solve_static(program(rod, 0.0))
    tips, errors = [], []
    for k in range(round(duration / time_step)):
        state = rod.step(state, program(rod, (k + 1) * time_step))
        tips.append(rod.tip(state)[0])
        errors.append(tip_error(rod, state))
    return np.array(tips), errors


CASES = {
    "paper's wire, 1.6 %, 60 N": (paper(damping=2e-4), 0.001, pulled(250.0)),
    "paper's wire, 0.8 %, push of 5 N": (paper(damping=1e-4), 0.005, pushed(5.0)),
    "nitinol, 4 %, 230 degrees, 2 ms": (nitinol(), 0.002, pulled(230.0)),
    "nitinol, 4 %, 230 degrees, 10 ms": (nitinol(), 0.01, pulled(230.0)),
}


@pytest.mark.parametrize("case", CASES)
def test_the_estimates_are_of_the_size_of_the_error(case: str) -> None:
    """Converged in space: eight modes a strain; in time: a tenth of the step."""
    robot, time_step, program = CASES[case]
    fine, _ = motion(with_modes(robot, 8), time_step, 0.3, program)
    finest, _ = motion(with_modes(robot, 8), 0.1 * time_step, 0.3, program)
    in_time = np.linalg.norm(fine - finest[9::10], axis=1).max()
    _, estimates = motion(with_modes(robot, 8), time_step, 0.3, program)
    assert in_time / 5.0 < max(one.time for one in estimates) < 5.0 * in_time
    for modes in (4, 5, 6):
        tips, estimates = motion(with_modes(robot, modes), time_step, 0.3, program)
        in_space = np.linalg.norm(tips - fine, axis=1).max()
        assert in_space / 5.0 < max(one.space for one in estimates) < 5.0 * in_space


def test_a_rod_at_rest_has_no_error_in_time_and_one_of_a_single_mode_no_estimate() -> None:
    rod = StrainRod(with_modes(paper(), 1))
    state = rod.solve_static(rod.loads([20.0, 0.0, 0.0, 0.0]))
    assert tip_error(rod, state) == (0.0, 0.0)
    assert tip_error(rod, rod.step(state, rod.loads([20.0, 0.0, 0.0, 0.0]))).time < 1e-9


@pytest.mark.parametrize("tolerance", [5e-3, 1e-3])
@pytest.mark.parametrize("robot", [paper(damping=1e-4), nitinol()], ids=["paper's wire", "nitinol"])
def test_refined_modes_and_steps_keep_their_tolerance(robot: Robot, tolerance: float) -> None:
    """The load that a lab would begin with: one tendon, half a turn in one period of the first mode."""
    found = refine(robot, 0.01, tolerance)
    assert found.reached
    plain = StrainRod(robot)
    rise = 1.0 / plain.frequencies(plain.rest(), plain.loads())[0]
    full = math.pi * robot.sections[0].bending_stiffness[0] / (robot.length * robot.tendons[0].at(0.0)[0])

    def ramp(time_step: float) -> Program:
        return lambda rod, t: rod.loads([full * min(1.0, max(0.0, t - 0.5 * time_step) / rise), 0.0, 0.0, 0.0])

    tips, _ = motion(found.robot, found.time_step, 0.5, ramp(found.time_step))
    finest, _ = motion(with_modes(robot, 8), 0.1 * found.time_step, 0.5, ramp(0.1 * found.time_step))
    assert np.linalg.norm(tips - finest[9::10], axis=1).max() < 2.0 * tolerance * robot.length


def test_what_was_found_is_said_and_more_modes_than_there_are_is_said_too() -> None:
    assert str(refine(paper(), 0.01, 5e-3)).startswith(
        "modes a section: 4 bending, 3 torsion, 1 stretch; time step 10 ms"
    )
    short = refine(with_modes(paper(), 7), 0.01, 1e-12, shorten=False)
    assert not short.reached
    assert str(short).endswith("which is all there is")


def test_a_tolerance_that_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match="tolerance = 0"):
        refine(paper(), 0.01, 0.0)


def test_a_force_across_a_bent_wire_needs_more_than_one_polynomial_of_torsion() -> None:
    """Random tensions and forces, beside a rod of eight and five: the default keeps 0.02 % L, one not 2 %."""

    def rod_of(bending: int, torsion: int) -> StrainRod:
        robot = with_modes(nitinol(), bending)
        return StrainRod(replace(robot, sections=(replace(robot.sections[0], torsion_modes=torsion),)))

    rods = rod_of(8, 5), StrainRod(nitinol()), rod_of(4, 1)
    stiffness = rods[0].robot.sections[0].bending_stiffness[0]
    rng, off = np.random.default_rng(1), []
    for _ in range(30):
        tension = rng.uniform(0.0, math.radians(90.0) * stiffness / 0.3 / 0.002, 4)
        force = rng.normal(size=3) * stiffness / 0.3**2
        tips = [rod.tip(rod.solve_static(rod.loads(tension, tip_force=force)))[0] for rod in rods]
        off.append([np.linalg.norm(tip - tips[0]) / 0.3 for tip in tips[1:]])
    assert np.max(off, axis=0)[0] < 2e-4
    assert np.max(off, axis=0)[1] > 2e-2
