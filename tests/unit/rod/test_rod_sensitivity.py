"""Rod.sensitivity is the derivative of what the rod would do: central differences of full solves say the same.

The differences are of fourth order, (8 (f(+h) - f(-h)) - (f(+2h) - f(-2h))) / 12h, from solves to 1e-11 N, and good to
1e-8. What differs is the solver's own Jacobian, of forward differences with a step of 1e-7. They leave out some 1e-7,
which the shooting's condition, tens, amplifies; and tendon lengths rounded at 1e-16 m are good to ROUNDING per newton.
Tendons of stiffness k that work against each other yield by 1/k per newton, so that there it counts k times.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypedDict

import numpy as np
import pytest

from tendond.model import ParameterError, Rod, RodParameters, RodState, Sensitivity
from tendond.model.solver.schemes import SCHEMES
from tests.unit.rod.rods import PAPER, THREE_TENDONS, WEIGHTLESS, Array, External, tip_motion

TRUNCATION = 1e-5
ROUNDING = 1.1e-9
"""2^-53 times a length of 0.5 m, twice, over a step of 1e-7 N [m/N]."""

TENSIONS = np.array([8.0, 4.0, 1.0, 0.5, 2.0, 3.0])
DISPLACEMENTS = np.array([6e-3, 3e-3, -5e-3, -4e-3, 0.0, 2e-3])
FORCE = np.array([0.2, 0.1, -0.1])

RODS = {"four tendons": PAPER, "three tendons, Bse": replace(THREE_TENDONS, shear_damping=(1.0, 1.0, 1.0))}


def differentiated(function: Callable[[Array], Array], at: Array, step: float) -> Array:
    """Jacobian by central differences of fourth order."""
    columns = []
    for index in range(len(at)):
        h = np.zeros(len(at))
        h[index] = step
        near, far = function(at + h) - function(at - h), function(at + 2.0 * h) - function(at - 2.0 * h)
        columns.append((8.0 * near - far) / (12.0 * step))
    return np.column_stack(columns)


def off(found: Array, expected: Array) -> float:
    """Largest error as a part of the largest entry."""
    return float(np.max(np.abs(found - expected)) / np.max(np.abs(expected)))


@pytest.mark.parametrize("space", list(SCHEMES))
@pytest.mark.parametrize("name", list(RODS))
@pytest.mark.parametrize("drive", ["tensions", "displacements"])
class TestSensitivity:
    """Sensitivity beside differences, of a bent rod under loads in three dimensions, at rest and in motion."""

    def setup(self, space: str, name: str, drive: str) -> tuple[Rod, Array, float, float]:
        """A rod, its tendon commands, a step to vary them by, and the agreement to expect."""
        parameters: RodParameters = RODS[name]
        n = parameters.tendon_count
        rod = Rod(parameters, space, tolerance=1e-11)
        if drive == "tensions":
            return rod, TENSIONS[:n], 1e-2, TRUNCATION
        return rod, DISPLACEMENTS[:n], 2e-6, TRUNCATION + n * ROUNDING * parameters.tendon_stiffness

    def test_statics(self, space: str, name: str, drive: str) -> None:
        rod, commands, step, agreement = self.setup(space, name, drive)
        state = static(rod, drive, commands, FORCE)
        found = rod.sensitivity(state)
        by_command = differentiated(lambda x: tip_motion(rod, static(rod, drive, x, FORCE, state)), commands, step)
        by_force = differentiated(lambda x: tip_motion(rod, static(rod, drive, commands, x, state)), FORCE, 1e-3)
        assert off(found.position_actuation, by_command[:3]) < agreement
        assert off(found.position_force, by_force[:3]) < agreement
        assert not np.any(found.velocity_actuation)
        assert not np.any(found.velocity_force)

    def test_a_time_step(self, space: str, name: str, drive: str) -> None:
        rod, commands, step, agreement = self.setup(space, name, drive)
        before = static(rod, drive, commands, FORCE)
        for more in (1.2, 1.3):
            before = moved(rod, before, drive, more * commands, 1.5 * FORCE)
        commands = 1.4 * commands
        found = rod.sensitivity(moved(rod, before, drive, commands, FORCE))
        by_command = differentiated(lambda x: tip_motion(rod, moved(rod, before, drive, x, FORCE)), commands, step)
        by_force = differentiated(lambda x: tip_motion(rod, moved(rod, before, drive, commands, x)), FORCE, 1e-2)
        assert off(found.position_actuation, by_command[:3]) < agreement
        assert off(found.velocity_actuation, by_command[3:]) < agreement
        assert off(found.position_force, by_force[:3]) < agreement
        assert off(found.velocity_force, by_force[3:]) < agreement


class Commands(TypedDict, total=False):
    """Command of the tendons: tensions [N] or displacements [m], not both."""

    tensions: Array
    displacements: Array


def commanded(drive: str, commands: Array) -> Commands:
    """Return the commands as the rod's keyword arguments."""
    return Commands(tensions=commands) if drive == "tensions" else Commands(displacements=commands)


def static(rod: Rod, drive: str, commands: Array, force: Array, start: RodState | None = None) -> RodState:
    """The equilibrium, near `start`."""
    return rod.solve_static(**commanded(drive, commands), **loaded(force), start=start)


def moved(rod: Rod, before: RodState, drive: str, commands: Array, force: Array) -> RodState:
    """One time step later."""
    return rod.step(before, **commanded(drive, commands), **loaded(force))


def loaded(force: Array) -> External:
    """A force on the tip, among other loads."""
    return External(tip_force=force.tolist(), tip_moment=(0.02, 0.01, -0.01), distributed_force=(0.1, 0.05, 0.0))


def test_it_predicts_the_next_step_of_a_straight_rod_where_b_c_is_zero() -> None:
    """The paper's b_c vanishes on a straight rod, whichever tendon pulls; the sensitivity does not."""
    rod = Rod(WEIGHTLESS, tolerance=1e-11)
    state = rod.step(rod.solve_static([1.0, 1.0, 1.0, 1.0]), [1.0, 1.0, 1.0, 1.0])
    assert np.max(np.abs(rod.tip(state).input_gain[:2])) < 1e-9
    found: Sensitivity = rod.sensitivity(state)
    assert found.velocity_actuation[0, 0] > 0.01
    assert found.velocity_actuation[:, 2] == pytest.approx(found.velocity_actuation[:, 0] * [-1.0, 1.0, 1.0], abs=1e-6)
    pulled = rod.step(state, [1.01, 1.0, 0.99, 1.0])
    held = rod.step(state, [1.0, 1.0, 1.0, 1.0])
    change = rod.tip(pulled).velocity - rod.tip(held).velocity
    predicted = rod.sensitivity(held).velocity_actuation @ [0.01, 0.0, -0.01, 0.0]
    assert change == pytest.approx(predicted, abs=1e-4 * float(np.linalg.norm(predicted)))


def test_a_slack_tendons_command_changes_nothing() -> None:
    rod = Rod(PAPER, tolerance=1e-11)
    state = rod.solve_static(displacements=DISPLACEMENTS[:4])
    slack = state.tensions == 0.0
    assert slack.any()
    assert not np.any(rod.sensitivity(state).position_actuation[:, slack])


@pytest.mark.parametrize("space", list(SCHEMES))
@pytest.mark.parametrize("name", list(RODS))
def test_the_velocity_jacobian_is_a_column_of_the_sensitivity_and_leaves_the_state_alone(space: str, name: str) -> None:
    parameters = RODS[name]
    n = parameters.tendon_count
    rod = Rod(parameters, space)
    state = rod.solve_static(np.zeros(n))
    assert not rod.velocity_jacobian(state, 0).any()
    for part in (0.3, 0.6, 1.0):
        state = rod.step(state, part * TENSIONS[:n], tip_force=part * FORCE)
        before = state.copy()
        whole = rod.sensitivity(state).velocity_actuation
        found = np.column_stack([rod.velocity_jacobian(state, tendon) for tendon in range(n)])
        assert off(found, whole) < TRUNCATION
        assert np.array_equal(before.levels, state.levels)
        assert np.array_equal(before.geometries, state.geometries)
    with pytest.raises(ParameterError, match="tendons 0 to"):
        rod.velocity_jacobian(state, n)
