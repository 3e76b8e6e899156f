"""Features of the learned correction: products of the commands, and on which side of its play each tendon is.

Commands are normalised to -1 to 1 over the training part; sides are -1 to 1, (u - c) over the play's half-width, of a
play operator of the width that the features name.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.offline.validation.baselines.polynomial import exponents, monomials

Array = NDArray[np.float64]


def names_of(tendons: int, degree: int) -> list[str]:
    """Return the features' names: "1", "c0", "c0*c2", ..., "side0", ..."""
    products = ["*".join(f"c{i}" for i in one) or "1" for one in exponents(tendons, degree)]
    return products + [f"side{i}" for i in range(tendons)]


def sides(command: Array, width: float) -> Array:
    """Return where each tendon is in a play of half-width `width` [m], -1: pulled last, 1: released last, (N, m)."""
    held = command[0].copy()
    found = np.empty_like(command)
    for i, now in enumerate(command):
        held = np.minimum(np.maximum(held, now - width), now + width)
        found[i] = (held - now) / width
    return found


def features_of(command: Array, low: Array, high: Array, degree: int, width: float) -> Array:
    """Return the features of a sequence of commands [m], shape (N, F)."""
    inputs = 2.0 * (command - low) / np.maximum(high - low, 1e-12) - 1.0
    return np.hstack([monomials(np.clip(inputs, -1.2, 1.2), degree), sides(command, width)])
