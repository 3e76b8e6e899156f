"""A tendon-driven robot as a lab would write it down: sections, tendons, bodies, base. SI units, validated."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain.describe.profile import PropertyProfile, Rows, Values, tabulated
from tendond.model.strain.describe.section import Section

Array = NDArray[np.float64]
Triple = tuple[float, float, float]
Route = Callable[[float], tuple[float, float]]
"""Position (x, y) of a tendon in the cross-section [m] at the arc length s [m] of the whole backbone."""


def ascending(values: Values) -> bool:
    """Return whether each value is above the one before it."""
    return all(one < other for one, other in pairwise(values))


def _pair(profile: PropertyProfile, s: float) -> tuple[float, float]:
    x, y = profile(s)
    return x, y


@dataclass(frozen=True)
class Tendon:
    """One tendon.

    Attributes:
        end: arc length at which it is fixed to the backbone [m].
        route: (x, y) in the cross-section [m], constant or a function of the arc length of the backbone [m].
        stiffness: force per stretch [N/m]; none: inextensible, so that it can only be driven by tension.
        friction: Coulomb's coefficient on its guides [-]. What lets it stick is its stretch: by `stiffness`, or 20 kN/m
            where none is given.
        knots: arc lengths between which the route is smooth [m].
        holes: arc lengths of the holes, ascending, at which alone it turns and rubs [m], beside the base's; none: all
            along its route, as in a sheath.
    """

    end: float
    route: tuple[float, float] | Route
    stiffness: float | None = None
    friction: float = 0.0
    knots: Values = ()
    holes: Values = ()

    def at(self, s: float) -> tuple[float, float]:
        """Position in the cross-section at the arc length s [m]."""
        return self.route(s) if callable(self.route) else self.route

    @staticmethod
    def tabulated(end: float, rows: Rows, stiffness: float | None = None, friction: float = 0.0) -> "Tendon":
        """Return a tendon through points (s, x, y) [m], straight from each to the next as between holes in disks."""
        profile = tabulated(rows, 2, "tendon: route")
        return Tendon(end, partial(_pair, profile), stiffness, friction, profile.knots)

    @staticmethod
    def helical(
        end: float,
        radius: float,
        turns: float,
        start: float = 0.0,
        stiffness: float | None = None,
        friction: float = 0.0,
    ) -> "Tendon":
        """Return a tendon that winds round the backbone at `radius` [m]: `turns` to its end, from `start` [rad]."""

        def route(s: float) -> tuple[float, float]:
            angle = start + 2.0 * math.pi * turns * s / end
            return radius * math.cos(angle), radius * math.sin(angle)

        quarters = math.ceil(4.0 * abs(turns)) if friction > 0.0 else 0  # its path bends from point to point
        knots = tuple(end * (index + 1) / quarters for index in range(quarters - 1))
        return Tendon(end, route, stiffness, friction, knots)

    @staticmethod
    def converging(
        end: float,
        first: tuple[float, float],
        last: tuple[float, float],
        stiffness: float | None = None,
        friction: float = 0.0,
    ) -> "Tendon":
        """Return a tendon that is straight in the straight robot, from `first` at the base to `last` at its end [m]."""

        def route(s: float) -> tuple[float, float]:
            part = s / end
            return first[0] + part * (last[0] - first[0]), first[1] + part * (last[1] - first[1])

        return Tendon(end, route, stiffness, friction)


@dataclass(frozen=True)
class Body:
    """A rigid body on the backbone: a disk, a tool, a marker.

    Attributes:
        at: arc length [m]. mass: [kg]. inertia: diagonal about its centre of mass, body frame [kg m^2].
        offset: from the backbone to its centre of mass, body frame [m].
    """

    at: float
    mass: float
    inertia: Triple = (0.0, 0.0, 0.0)
    offset: Triple = (0.0, 0.0, 0.0)

    def points(self) -> list[tuple[float, Array]]:
        """Return mass points [kg, m] with the same mass, centre and inertia.

        Six points on the principal axes, at the distances at which their squares sum up to the second moments; a
        plate's inertia (one moment the sum of the others) leaves two of them at the centre.
        """
        centre = np.array(self.offset)
        if self.mass == 0.0:
            return [(0.0, np.zeros(3))]  # a node that can be loaded
        moments = np.array(self.inertia)
        second = 0.5 * moments.sum() - moments  # of mass along each axis
        if np.any(second < -1e-9 * max(moments.max(), 1e-300)):
            raise ParameterError(
                f"body: inertia = {self.inertia} is not that of any body: the largest exceeds the others' sum"
            )
        if not moments.any():
            return [(self.mass, centre)]
        found = []
        for axis in range(3):
            reach = math.sqrt(max(second[axis], 0.0) * 3.0 / self.mass)
            for sign in (-1.0, 1.0):
                point = centre.copy()
                point[axis] += sign * reach
                found.append((self.mass / 6.0, point))
        return found


@dataclass(frozen=True)
class Robot:
    """A tendon-driven continuum robot, clamped at its base.

    Attributes:
        sections: from the base to the tip. tendons: in the order of their tensions.
        bodies: rigid bodies on the backbone.
        gravity: world frame [m/s^2].
        base: orientation of the base, body to world, shape (3, 3). origin: its position, world frame [m].
    """

    sections: tuple[Section, ...]
    tendons: tuple[Tendon, ...] = ()
    bodies: tuple[Body, ...] = ()
    gravity: Triple = (0.0, 0.0, 0.0)
    base: Array = field(default_factory=lambda: np.eye(3))
    origin: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not self.sections:
            raise ParameterError("robot: sections is empty: it has at least one")
        length = self.length
        for index, tendon in enumerate(self.tendons):
            if not 0.0 < tendon.end <= length * (1.0 + 1e-9):
                raise ParameterError(f"tendon {index}: end = {tendon.end} must lie on the backbone, in 0..{length:g} m")
            if tendon.stiffness is not None and not (math.isfinite(tendon.stiffness) and tendon.stiffness > 0.0):
                raise ParameterError(f"tendon {index}: stiffness = {tendon.stiffness!r} must be finite and above 0")
            if not (math.isfinite(tendon.friction) and tendon.friction >= 0.0):
                raise ParameterError(f"tendon {index}: friction = {tendon.friction!r} must be finite and not negative")
            if not all(0.0 < one <= length * (1.0 + 1e-9) for one in tendon.holes) or not ascending(tendon.holes):
                raise ParameterError(f"tendon {index}: holes must ascend, on the backbone, in 0..{length:g} m")
        for index, body in enumerate(self.bodies):
            if not 0.0 <= body.at <= length * (1.0 + 1e-9):
                raise ParameterError(f"body {index}: at = {body.at} must lie on the backbone, in 0..{length:g} m")
            if not (math.isfinite(body.mass) and body.mass >= 0.0 and min(body.inertia) >= 0.0):
                raise ParameterError(f"body {index}: mass and inertia must be finite and not negative")
        for name in ("gravity", "origin"):
            if not all(math.isfinite(one) for one in getattr(self, name)):
                raise ParameterError(f"robot: {name} is not finite")
        if np.shape(self.base) != (3, 3) or not np.allclose(self.base @ self.base.T, np.eye(3), atol=1e-9):
            raise ParameterError("robot: base is not a rotation matrix, shape (3, 3)")

    @property
    def length(self) -> float:
        """Length of the backbone [m]."""
        return float(sum(section.length for section in self.sections))
