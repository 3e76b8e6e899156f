"""Kernels of the general rod as Python calls them: layout and scratch arrays are parked, see `Parked`."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.parked import Parked, unpark
from tendond.model.strain.dynamics import advance
from tendond.model.strain.equations import Loads
from tendond.model.strain.statics import minimise

Array = NDArray[np.float64]


@lean
def advance_parked(
    parked: Parked, loads: Loads, q: Array, w: Array, h: float, tolerance: float
) -> tuple[int, int, int]:
    """Advance q and w by the time h, in place; see `advance`."""
    layout, work = unpark(parked)
    found: tuple[int, int, int] = advance(layout, loads, q, w, h, tolerance, work)
    return found


@lean
def minimise_parked(parked: Parked, loads: Loads, q: Array, tolerance: float) -> int:
    """Move q to an equilibrium, in place; see `minimise`."""
    layout, work = unpark(parked)
    count: int = minimise(layout, loads, q, 0.0, tolerance, work)
    return count
