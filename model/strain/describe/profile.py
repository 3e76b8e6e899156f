"""Properties that change along a section or a tendon: tables, linear between their points."""

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise

from tendond.model.errors import ParameterError

Values = tuple[float, ...]
Rows = Sequence[Sequence[float]]


@dataclass(frozen=True)
class PropertyProfile:
    """A property along an arc length.

    Attributes:
        knots: arc lengths between which it is smooth [m], ascending.
        function: its values at an arc length [m].
    """

    knots: Values
    function: Callable[[float], Values]

    def __call__(self, s: float) -> Values:
        """Return the values at the arc length s [m]."""
        return self.function(s)


def tabulated(rows: Rows, width: int, name: str) -> PropertyProfile:
    """Return the property that rows (s [m], values...) give: linear between them, constant beyond them.

    Args:
        rows: at least two, s ascending; also an array, shape (N, 1 + width).
        width: number of values in a row.
        name: of the property, for messages.

    Raises:
        ParameterError: fewer rows, rows of another length, not finite, or not ascending.
    """
    try:
        table = tuple(tuple(float(one) for one in row) for row in rows)
    except TypeError:
        table = ()
    if len(table) < 2 or any(len(row) != 1 + width for row in table):
        raise ParameterError(f"{name}: a table has two or more rows (s, {width} value{'s' if width > 1 else ''})")
    if not all(math.isfinite(one) for row in table for one in row):
        raise ParameterError(f"{name}: the table is not finite")
    at = tuple(row[0] for row in table)
    if any(left >= right for left, right in pairwise(at)):
        raise ParameterError(f"{name}: s must ascend from row to row")
    return PropertyProfile(at, partial(_linear, at, tuple(row[1:] for row in table)))


def combined(function: Callable[..., Values], *parts: PropertyProfile) -> PropertyProfile:
    """Return the property that `function` makes of the values of others at the same place, in their order."""
    knots = tuple(sorted({one for part in parts for one in part.knots}))
    return PropertyProfile(knots, partial(_joined, function, parts))


def constant(*values: float) -> PropertyProfile:
    """Return the property that is the same everywhere."""
    return PropertyProfile((), partial(_same, values))


def _same(values: Values, s: float) -> Values:
    return values


def _joined(function: Callable[..., Values], parts: tuple[PropertyProfile, ...], s: float) -> Values:
    return function(*(one for part in parts for one in part(s)))


def _linear(at: Values, values: tuple[Values, ...], s: float) -> Values:
    if s <= at[0]:
        return values[0]
    if s >= at[-1]:
        return values[-1]
    right = bisect_right(at, s)
    share = (s - at[right - 1]) / (at[right] - at[right - 1])
    return tuple(a + share * (b - a) for a, b in zip(values[right - 1], values[right], strict=True))


class Factor:
    """Multiplies numbers by a factor; a class, so that a robot can be pickled."""

    def __init__(self, factor: float) -> None:
        self.factor = factor

    def __call__(self, *values: float) -> tuple[float, ...]:
        return tuple(self.factor * one for one in values)
