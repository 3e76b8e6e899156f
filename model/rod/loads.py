"""Loads on a rod, checked and packed into the one array that the kernels take.

Tendon commands n, tip force 3, tip moment 3, distributed force with gravity's share 3, distributed moment 3, push 3.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ParameterError
from tendond.model.solver.schemes import Scheme

Array = NDArray[np.float64]

ZERO = (0.0, 0.0, 0.0)
_NAMES = ("tendon commands", "tip_force", "tip_moment", "distributed_force", "distributed_moment", "push")


def pack_loads(count: int, weight: Array, parts: tuple[ArrayLike, ...]) -> Array:
    """Pack all loads into one array, shape (n + 15,).

    Args:
        count: count of tendons, n.
        weight: loads of gravity, shape (n + 15,), that are added.
        parts: tendon commands [N] or [m], shape (n,), and five vectors of shape (3,); `ZERO` itself costs nothing.

    Raises:
        ParameterError: loads of the wrong shape or not finite.
    """
    loads, at = np.zeros(weight.size), 0
    for name, part in zip(_NAMES, parts, strict=True):
        size = 3 if at else count
        if part is not ZERO:
            array = np.asarray(part, dtype=np.float64)
            if array.shape != (size,):
                raise ParameterError(f"{name} has shape {array.shape}, must be ({size},)")
            if not all(map(math.isfinite, array.tolist())):
                raise ParameterError(f"{name} = {array.tolist()} must be finite")
            loads[at : at + size] = array
        at += size
    loads += weight
    return loads


def tendon_commands(count: int, tensions: ArrayLike | None, displacements: ArrayLike | None) -> tuple[ArrayLike, bool]:
    """Check the commands of the tendons; return them, and True if they are displacements. Default: zero tensions.

    Raises:
        ParameterError: both, or a negative tension.
    """
    if (tensions is None) == (displacements is None):
        if tensions is not None:
            raise ParameterError("give tensions or displacements, not both")
        return np.zeros(count), False
    if displacements is not None:
        return displacements, True
    array = np.asarray(tensions, dtype=np.float64)
    if any(tension < 0.0 for tension in array.ravel().tolist()):
        raise ParameterError(f"tensions = {array.tolist()} must not be negative: a tendon cannot push")
    return array, False


def push_shape(scheme: Scheme, nodes: int, ds: float, place: float, half_width: float) -> Array:
    """Density of a push [1/m] at the stages of all steps, shape ((nodes - 1) s,): a parabola whose integral is one.

    Args:
        scheme: in space, of s stages. nodes: base and tip included. ds: their distance [m].
        place: place of the parabola's middle, as a part of the length.
        half_width: likewise; at least half a node's distance, so that every scheme sees it.

    Raises:
        ParameterError: a place off the rod, or no width.
    """
    if not 0.0 <= place <= 1.0 or not half_width > 0.0:
        raise ParameterError(f"place = {place} must lie in [0, 1] and half_width = {half_width} be above 0")
    steps = nodes - 1
    tableau, weights = scheme.arrays()
    at = (np.arange(steps)[:, None] + np.sum(tableau, axis=1)).ravel() / steps
    shares = np.tile(np.asarray(weights) * ds, steps)
    width = max(half_width, 0.5 / steps)
    middle = min(max(place, width), 1.0 - width)
    shape = np.maximum(0.0, 1.0 - ((at - middle) / width) ** 2)
    return np.asarray(shape / float(shares @ shape))
