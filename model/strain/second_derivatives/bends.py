"""Arrays that second derivatives of a shape work in."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.parked import park
from tendond.model.numerics.products import padded
from tendond.model.strain.directions import DIRECTIONS, Directions, directions_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.spans import spans_of

Array = NDArray[np.float64]


class Bends(NamedTuple):
    """Room for second derivatives.

    Attributes:
        directions: of the strain.
        change, dual, pull: of the Magnus twist, and of wrenches, in every lane: six rows of DIRECTIONS each.
        block: second derivatives, DIRECTIONS rows of DIRECTIONS. spread: the same by the modes, padded rows.
        left, other, right, total, second: for `add_products`. own: second derivatives of the intervals, padded rows.
        pushes, others: sums of `left` and `other` over a section, three rows.
    """

    directions: Directions
    change: Array
    dual: Array
    pull: Array
    block: Array
    spread: Array
    left: Array
    other: Array
    right: Array
    total: Array
    second: Array
    own: Array
    pushes: Array
    others: Array


def bends_of(layout: Layout) -> Bends:
    """Return arrays for the second derivatives of this robot's shape."""
    intervals, n = layout.at1.shape
    width = padded.py_func(n)
    sizes = {"block": DIRECTIONS**2, "spread": DIRECTIONS * width}
    sizes |= dict.fromkeys(("total", "second", "own"), width**2)
    sizes |= dict.fromkeys(("change", "dual", "pull"), 6 * DIRECTIONS)
    sizes |= dict.fromkeys(("left", "other", "right"), 3 * intervals * width)
    sizes |= dict.fromkeys(("pushes", "others"), 3 * int(spans_of(layout).width[0]))
    bends = Bends(directions_of(layout), **{name: np.zeros(size) for name, size in sizes.items()})
    return park(bends)
