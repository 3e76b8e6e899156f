"""Outputs of a control law: tensions, and terms for the record."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Pair = tuple[float, float]
"""Components across and along the straight rod, in the bending plane."""


@dataclass(frozen=True)
class LawTerms:
    """Base of a law's terms: its intermediate results, for the record and for plots; floats and tuples of them, SI."""


@dataclass(frozen=True)
class Decision:
    """Output of a law.

    Attributes:
        tension: tensions before any limit [N], shape (n,).
        terms: intermediate results.
        state: state of the law after the cycle; none for a law without one.
    """

    tension: Array
    terms: LawTerms
    state: Any = None
