"""Stiffness of the bent arm with a mass on its tip: what the margin for that mass assumes of it."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.gains import usual_tip_mass
from tendond.daemon.control.reference.planar import PLANES
from tendond.drivers.simulator.rods import PlantRod, plant_rod
from tendond.model.errors import ConvergenceError
from tendond.model.estimation.compliance import tip_compliance
from tendond.model.rods.selection import model_rod, solver_of
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.simulator import SimulatorSection

Array = NDArray[np.float64]

PUSH = 1e-3
"""Force by which the compliance is measured, of that which bends the straight rod by a third of its length [-]."""


@dataclass(frozen=True)
class StiffnessRow:
    """Stiffness of the tip in its min_stiffness_ratio direction, of the straight rod's 3 EI/L^3 [-].

    Attributes:
        mass: mass on the tip [kg]. tension: tension of the agonist [N]. across: the tip's position [m].
        arm: stiffness of the arm, by pushing its tip. observer: the observer's value.
    """

    mass: float
    tension: float
    across: float
    arm: float
    observer: float


def stiffness_rows(config: RigConfig) -> Iterator[StiffnessRow]:
    """Yield a mass's effect on the bent arm's stiffness, the source of `BENT_STIFFNESS` and `GRAVITY_SOFTENING`."""
    model = model_rod(config)
    solver = solver_of(config.rod, config.control.solver)
    rod = plant_rod(SimulatorSection(rod=config.rod, solver=solver), config.loop.period)
    parameters, control = model.parameters, config.control
    straight = 3.0 * parameters.bending_stiffness / parameters.length**3
    axes = PLANES[control.plane]
    push = PUSH * straight * parameters.length
    largest = usual_tip_mass(config, parameters)
    for mass in (0.0, 0.5 * largest, largest):
        rod.load_tip(mass)
        tension = np.zeros(parameters.tendon_count)
        state = rod.solve_static(tension)
        for pull in np.linspace(0.0, 0.8 * config.limits.tension_max, 13):
            tension[control.agonist] = pull
            try:
                state = rod.solve_static(tension, start=state)
                compliance = _compliance(rod, state, tension, push, axes)
            except ConvergenceError:
                break
            arm = 1.0 / float(np.max(np.linalg.eigvals(compliance).real))
            assumed = tip_compliance(model, state)[np.ix_(axes, axes)]
            observer = 1.0 / float(np.max(np.linalg.eigvalsh(assumed)))
            across = float(rod.tip(state).position[axes[0]])
            yield StiffnessRow(mass, float(pull), across, arm / straight, observer / straight)


def _compliance(rod: PlantRod, state: object, tension: Array, push: float, axes: tuple[int, int]) -> Array:
    """Return the tip's compliance in a plane by central differences [m/N], shape (2, 2)."""
    columns = []
    for axis in axes:
        force = np.zeros(3)
        force[axis] = push
        ends = [
            rod.tip(rod.solve_static(tension, tip_force=sign * force, start=state)).position for sign in (1.0, -1.0)
        ]
        columns.append((ends[0] - ends[1])[list(axes)] / (2.0 * push))
    return np.array(columns).T
