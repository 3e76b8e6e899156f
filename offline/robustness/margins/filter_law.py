"""Derivatives of a law's tensions about a rest, by central differences of the controller's own functions."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.tasks.space import SpatialTask
from tendond.daemon.control.tasks.task import Situation
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.rods.general import GeneralRod, GeneralState

Array = NDArray[np.float64]

STILL = 1e4
"""Time of tracking at which the reference rests [s]."""

SMALL = 1e-4
"""Difference of strains in the law's derivatives, bend over the length [rad]; of loads in EI/L^2. With a smaller one,
the tolerance of the rod's steps shows at high rates."""


def law_matrix(setup: CycleSetup, started: EstimatorState, rest: GeneralState, m: int) -> Array:
    """Difference the law; see `filter_parts.ModelParts.law`. The sliding mode's sign is left out."""
    rod, selection = setup.rod, setup.selection
    assert isinstance(rod, GeneralRod)
    parameters = selection.parameters
    if hasattr(parameters, "epsilon"):
        parameters = parameters.model_copy(update={"epsilon": 0.0})
    n, (x, y, z) = rod.strain_rod.modes, rest.position.tolist()
    reference = selection.reference.at(STILL).model_copy(update={"position": (x, y, z)})
    shift = z - reference.target[2] if not isinstance(selection.task, SpatialTask) else 0.0

    def wanted(values: Array) -> Array:
        q, w, v, applied, force, wrong, acted, pushed = np.split(values, np.cumsum([n, n, 3, m, 3, m, m]))
        strain = replace(rest.strain, strain=q, rate=w, earlier=None)
        position = rod.strain_rod.tip(strain)[0]
        state = replace(rest, strain=strain, position=position, velocity=v, tensions=np.maximum(acted, 0.0))
        state = replace(state, tip_force=pushed)
        known = replace(started, force=force, tension_error=wrong)
        tip = rod.tip(state)
        given = (
            rod,
            state,
            tip,
            applied,
            known.acting(applied),
            known,
            position,
            v,
            reference,
            STILL,
            shift,
            applied,
            drawn,
        )
        law = selection.law
        before: Any = law.start(parameters)
        ruling = selection.task.rule(lambda seen: law.decide(parameters, seen, before), Situation(*given))
        return np.asarray(ruling.tension, dtype=np.float64)

    tensions, length, drawn = rest.tensions, rod.robot.length, rod.displacements(rest)
    unit = rod.parameters.bending_stiffness / length**2
    start = np.concatenate((rest.strain.strain, np.zeros(n + 3), tensions, np.zeros(3 + m), tensions, np.zeros(3)))
    strain, tension, force = np.full(n, SMALL / length), np.full(m, SMALL * unit), np.full(3, SMALL * unit)
    sizes = np.concatenate((
        strain, strain / rod.time_step, np.full(3, SMALL * length), tension, force, tension, tension, force,
    ))  # fmt: skip
    found = differences(wanted, start, sizes)
    slack = np.flatnonzero(tensions <= 0.0)
    for first in (2 * n + 3, 2 * n + 6 + m, 2 * n + 6 + 2 * m):
        found[:, first + slack] = 0.0
    found[slack] = 0.0
    return found


def differences(function: Callable[[Array], Array], start: Array, sizes: Array) -> Array:
    """Return the derivatives of a function by central differences, a column a number."""
    columns = []
    for size, one in zip(sizes, np.eye(len(start)), strict=True):
        ahead, back = start + size * one, start - size * one
        columns.append((function(ahead) - function(back)) / (2.0 * size))
    return np.stack(columns, axis=1)
