"""A first guess of lag and backlash, from the servos' reports alone."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tendond.offline.identification.parameter import Parameter, bounds
from tendond.offline.identification.simulation.simulated import Simulated

Array = NDArray[np.float64]


def servo_start(simulations: Sequence[Simulated], parameters: Sequence[Parameter], start: Mapping[str, float]) -> Array:
    """Find coordinates to start a fit from, shape (p,): lag and backlash from the servos' reports alone.

    The servos' response needs no rod, and the backlash, whose residuals have kinks, needs a good first guess.
    """
    at = np.zeros(len(parameters))
    rows = [k for k, parameter in enumerate(parameters) if parameter.name in ("lag", "backlash")]
    if not rows or any(simulation.drive != "measured" for simulation in simulations):
        return at

    def apart(coordinates: Array) -> Array:
        values = dict(start)
        for k, coordinate in zip(rows, coordinates, strict=True):
            values[parameters[k].name] = parameters[k].value(float(coordinate), start[parameters[k].name])
        return np.concatenate([simulation.servos_apart(values).ravel() for simulation in simulations])

    span = np.array([bounds(parameters[k], start[parameters[k].name]) for k in rows])
    best: tuple[float, Array] | None = None
    for guess in (0.0, 1.0, 4.0):  # [10 ms] and [0.1 mm] above the start, within the bounds
        first = np.clip(guess, span[:, 0] + 1e-3, span[:, 1] - 1e-3)
        if not apart(first).size:
            return at
        found = least_squares(
            apart, first, bounds=(span[:, 0], span[:, 1]), diff_step=np.full(len(rows), 1e-3), x_scale=1.0
        )
        if best is None or found.cost < best[0]:
            best = float(found.cost), found.x
    assert best is not None
    at[rows] = best[1]
    return at
