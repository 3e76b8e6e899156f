"""What acts on the rods of a batch, by what a person names, and as the kernel takes it."""

from collections.abc import Sequence
from typing import TypedDict

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain.describe.base import Base, at_rest, is_placed, later
from tendond.model.strain.stepping.many import Inputs

Array = NDArray[np.float64]

Bases = Base | None | Array | Sequence["Bases"]
"""One for all rods, one a rod, or, of each step, one a rod; arrays: of rows by `Base.row`, or zeros for none."""


class Acting(TypedDict, total=False):
    """What acts on N rods over some steps; m tendons.

    Attributes:
        tension: of the tendons [N], shape (m,), (N, m), or (steps, N, m).
        displacement: of the tendons' ends [m] instead; of elastic tendons.
        tip_force: dead, world frame [N], shape (3,), (N, 3), or (steps, N, 3); default: none.
        base: at the start of each step, as `StrainRod.step` takes it, shape (25,), (N, 25), or (steps, N, 25); without
            a number of steps that at the start of the first, whose accelerations are held over all of them. Default
            and None: at rest where the rod's base is.
    """

    tension: ArrayLike
    displacement: ArrayLike
    tip_force: ArrayLike
    base: Bases


def inputs_of(acting: Acting, stiffness: Array, base: Array, steps: int, time_step: float) -> tuple[Inputs, Array]:
    """Return the kernel's inputs, and the bases after the steps, shape (N, 25).

    Args:
        acting: on the rods. stiffness: of the tendons [N/m], 0: none, shape (N, m).
        base: of each rod before the steps, shape (N, 25). steps: number of them. time_step: of each [s].

    Raises:
        ParameterError: not finite, of another shape, a negative tension, both or neither of tension and displacement,
            a displacement of a tendon without stiffness, or a base whose rotation is none.
    """
    if ("tension" in acting) == ("displacement" in acting):
        raise ParameterError("batch: give tension or displacement, one of them")
    lanes, tendons = stiffness.shape
    driven = "displacement" in acting
    given = acting["displacement"] if driven else acting["tension"]
    actuation = _given("displacement" if driven else "tension", given, steps, lanes, tendons)
    if not driven and np.any(actuation < 0.0):
        raise ParameterError("batch: a tendon cannot push: tension must not be negative")
    if driven and np.any(stiffness <= 0.0):
        raise ParameterError("batch: a tendon without stiffness can only be driven by tension")
    force = _given("tip_force", acting.get("tip_force", np.zeros(3)), steps, lanes, 3)
    rows, ahead = _bases(_given("base", _rows(acting.get("base")), steps, lanes, 25), base, steps, time_step)
    return Inputs(actuation, driven, force, rows), ahead


def _given(name: str, value: ArrayLike, steps: int, lanes: int, width: int) -> Array:
    """Return numbers per step and rod, shape (1 or steps, N, width)."""
    found = np.asarray(value, dtype=np.float64)
    shape = (steps if found.ndim == 3 else 1, lanes, width)
    try:
        found = np.array(np.broadcast_to(found, shape), order="C")  # a copy: never read-only
    except ValueError:
        raise ParameterError(
            f"batch: {name} has shape {np.shape(found)}: it must be one of ({width},), ({lanes}, {width}), "
            f"({steps}, {lanes}, {width})"
        ) from None
    if not np.all(np.isfinite(found)):
        raise ParameterError(f"batch: {name} is not finite")
    return found


def _rows(base: Bases) -> Array:
    """Return rows of numbers, shape (..., 25)."""
    if isinstance(base, np.ndarray):
        return base
    if base is None:
        return np.zeros(25)
    return base.row() if isinstance(base, Base) else np.array([_rows(one) for one in base])


def _bases(given: Array, before: Array, steps: int, time_step: float) -> tuple[Array, Array]:
    """Return the bases of the steps, shape (1 or steps, N, 25), and those after them, shape (N, 25)."""
    if not (given.any() or before.any()):
        return given, before
    if not is_placed(given):
        raise ParameterError("batch: base has a row that is neither zeros nor 1 and a rotation matrix first")
    if len(given) == 1 and steps > 1:
        given = np.concatenate([later(given, k * time_step) for k in range(steps)])
    for rows in given:
        still = rows[:, 0] == 0.0
        rows[still] = at_rest(before[still])
        before = later(rows, time_step)
    return given, before
