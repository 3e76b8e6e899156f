"""Loads on the general rod over a step, by what a person names: tendons, wrenches, loads along the backbone."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain.discretise.quadrature import gauss, lobatto, nodes_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.robot import Robot
from tendond.model.strain.stepping.scratch import Loads

Array = NDArray[np.float64]
Drive = ArrayLike | Sequence[float | None] | None
"""A number per tendon; None for one that is not driven so."""

Wrench = tuple[float, ArrayLike, ArrayLike]
"""Arc length [m], force [N], moment [N m]; world frame."""

Distributed = tuple[float, float, ArrayLike, ArrayLike]
"""First and last arc length [m], force per length [N/m], moment per length [N]; world frame."""

Node = Callable[[float], tuple[int, int]]
"""Node and mass point at an arc length."""


def make_loads(
    layout: Layout,
    robot: Robot,
    node: Node,
    tension: Drive,
    displacement: Drive,
    tip_force: ArrayLike,
    wrenches: Sequence[Wrench],
    distributed: Sequence[Distributed],
) -> Loads:
    """Return the kernels' loads; see `StrainRod.loads`.

    Raises:
        ParameterError: see there.
    """
    actuation, driven = _actuation(layout, tension, displacement)
    force, moment = np.zeros((len(layout.mass), 3)), np.zeros((len(layout.polar), 3))
    force[node(robot.length)[1]] += _three(tip_force, "tip_force")
    for at, pushed, turned in wrenches:
        place, point = node(at)
        force[point] += _three(pushed, f"force at s = {at:g} m")
        moment[place] += _three(turned, f"moment at s = {at:g} m")
    for start, end, pushed, turned in distributed:
        if not 0.0 <= start < end <= robot.length * (1.0 + 1e-9):
            raise ParameterError(
                f"loads: a distributed load from {start} to {end} m must lie on the backbone, in 0..{robot.length:g} m"
            )
        name = f"load per length from s = {start:g} to {end:g} m"
        _spread(robot, node, (start, end), _three(pushed, name), _three(turned, name), force, moment)
    return Loads(force, actuation, driven, moment)


def _three(value: ArrayLike, name: str) -> Array:
    found = np.asarray(value, dtype=np.float64)
    if found.shape != (3,) or not np.all(np.isfinite(found)):
        raise ParameterError(f"loads: {name} must be three finite numbers")
    return found


def _numbers(value: Drive, count: int) -> Array:
    """Numbers per tendon, NaN for None, shape (m,)."""
    if value is None:
        return np.full(count, np.nan)
    items: list[Any] = list(np.asarray(value, dtype=object).reshape(-1))
    if len(items) != count or any(one is not None and not np.isfinite(float(one)) for one in items):
        raise ParameterError(f"loads: {count} finite numbers are needed, one per tendon")
    return np.array([np.nan if one is None else float(one) for one in items], dtype=np.float64)


def _actuation(layout: Layout, tension: Drive, displacement: Drive) -> tuple[Array, NDArray[np.bool_]]:
    """Return tension [N] or displacement [m] of each tendon, and which of them are displacements, shape (m,)."""
    count = len(layout.straight)
    pulls, displacements = _numbers(tension, count), _numbers(displacement, count)
    driven = np.isfinite(displacements)
    both, neither = driven & np.isfinite(pulls), ~driven & ~np.isfinite(pulls)
    if both.any() or (neither.any() and not (tension is None and displacement is None)):
        index = int(np.argmax(both | neither))
        raise ParameterError(f"loads: tendon {index} needs a tension or a displacement, one of the two")
    if np.any(pulls[~driven] < 0.0):
        raise ParameterError("loads: a tendon cannot push: tension must not be negative")
    if np.any(layout.tendon_stiffness[driven] <= 0.0):
        raise ParameterError("loads: a tendon without stiffness can only be driven by tension")
    return np.where(driven, displacements, np.nan_to_num(pulls)), driven


def _spread(
    robot: Robot, node: Node, span: tuple[float, float], pushed: Array, turned: Array, force: Array, moment: Array
) -> None:
    """Add a uniform load per length to the mass points: its integral with the Lagrange polynomials of each section."""
    begin = 0.0
    for section in robot.sections:
        left, right = max(span[0] - begin, 0.0), min(span[1] - begin, section.length)
        parts, _ = lobatto(nodes_of(section))
        if right > left:
            shares = np.zeros(len(parts))
            for x, weight in zip(*gauss(len(parts)), strict=True):
                at = (left + x * (right - left)) / section.length
                for i in range(len(parts)):
                    others = np.delete(parts, i)
                    shares[i] += weight * (right - left) * np.prod((at - others) / (parts[i] - others))
            for part, share in zip(parts, shares, strict=True):
                if begin + part * section.length > 0.0:  # the base is clamped
                    place, point = node(begin + part * section.length)
                    force[point] += share * pushed
                    moment[place] += share * turned
        begin += section.length
