"""The likeliest mistake behind a rest that no right rig has: which transform of the measured pose makes it fit."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.rests import FREE, Fit, RestFamily
from tendond.daemon.control.commissioning.rotations import rotation_matrix, rotation_vectors, turn_by

Array = NDArray[np.float64]
Quaternion = tuple[float, float, float, float]

SCALES = {1e3: "in mm", 1e2: "in cm", 1e-3: "in km: is it divided by 1000 twice?", 1 / 0.0254: "in inches"}
"""Unit of the measured length, by its number per metre."""

AXES = "xyz"
NAMED = 2
"""Largest number of mistakes that a refusal names."""

TURNS = 5
"""Repetitions of the fit of a large turn; three give ten digits at 30 degrees."""

FARTHEST = 0.6
"""Largest offset of the base that is considered, of the rod's length: above the 0.5 that `commissioning.offset` may be.
Chosen; it changes no refusal, only the words of one."""

NEAR = 0.02
"""Distance from the straight rod's tip below which a tip counts as held there, of the rod's length. Chosen;
it changes no refusal, only the words of one."""


@dataclass(frozen=True)
class Signed:
    """A signed permutation of the axes, as one mistakes a frame: measured = matrix @ true."""

    name: str
    matrix: Array


STRAIGHT = "the arm is straight: is it held, or does rod.gravity point another way?"


def _frames() -> tuple[Signed, ...]:
    """All 47 of them but the identity, the likelier ones first."""
    found = []
    for order in itertools.permutations(range(3)):
        for signs in itertools.product((1.0, -1.0), repeat=3):
            matrix = np.zeros((3, 3))
            for row, (column, sign) in enumerate(zip(order, signs, strict=True)):
                matrix[row, column] = sign
            if not np.array_equal(matrix, np.eye(3)):
                found.append(Signed(_frame_name(order, signs, matrix), matrix))
    return tuple(sorted(found, key=lambda one: len(one.name)))


def _frame_name(order: tuple[int, ...], signs: tuple[float, ...], matrix: Array) -> str:
    """Name a frame: a swap, a mirror, a quarter or half turn; else the measured axes in terms of the true ones."""
    moved = [axis for axis in range(3) if order[axis] != axis]
    negative = [axis for axis in range(3) if signs[axis] < 0.0]
    if not moved and len(negative) == 1:
        return f"with {AXES[negative[0]]} mirrored"
    if not moved and len(negative) == 3:
        return "with all axes mirrored"
    if len(moved) == 2 and not negative:
        return f"with {AXES[moved[0]]} and {AXES[moved[1]]} swapped"
    if np.linalg.det(matrix) > 0.0:
        turn = rotation_vectors(matrix)
        degrees = round(math.degrees(float(np.linalg.norm(turn))))
        axis = np.flatnonzero(np.abs(turn) > 1e-6)
        if len(axis) == 1:
            sign = "-" if turn[axis[0]] < 0.0 and degrees < 180 else ""
            return f"rotated by {sign}{degrees} degrees about {AXES[axis[0]]}"
    axes = ", ".join(f"{'-' if sign < 0 else ''}{AXES[axis]}" for axis, sign in zip(order, signs, strict=True))
    return f"with axes (x, y, z) that are the model's ({axes})"


FRAMES = _frames()
ORDERS = {
    "with its quaternion in the order x y z w": (3, 0, 1, 2),
}
"""Indices of w, x, y, z in a quaternion of another order."""


def likely_mistakes(rests: RestFamily, position: Array, quaternion: Quaternion) -> list[str]:
    """Return the mistakes that a measured rest looks like, the likeliest first; never empty.

    Args:
        rests: rests of right rigs. position: measured [m], shape (3,). quaternion: measured, w, x, y, z.
    """
    rotation = rotation_matrix(quaternion)
    if _is_straight(rests, position, rotation):
        return [STRAIGHT]
    found: dict[str, None] = {}
    for name in itertools.chain(_exact(rests, position, quaternion, rotation), _measured(rests, position, rotation)):
        found[name] = None
        if len(found) == NAMED:
            break
    return list(found) or [_unexplained(rests, position, rotation)]


def _exact(rests: RestFamily, position: Array, quaternion: Quaternion, rotation: Array) -> Iterator[str]:
    """Mistakes without a number."""
    for name, order in ORDERS.items():
        w, x, y, z = (quaternion[index] for index in order)
        if _fits(rests, position, rotation_matrix((w, x, y, z))):
            yield f"measured = model {name}"
    if _fits(rests, position, rotation.T):
        yield "measured = model with its orientation inverted (base seen from the tip)"
    for scale, name in SCALES.items():
        if _fits(rests, position / scale, rotation):
            yield f"measured = model {name}"
    for frame in FRAMES:
        m = frame.matrix
        turned = [m.T @ rotation @ m, rotation]
        if np.linalg.det(m) > 0.0:
            turned.append(m.T @ rotation)
        if any(_fits(rests, m.T @ position, one) for one in turned):
            yield f"measured = model {frame.name}"


def _measured(rests: RestFamily, position: Array, rotation: Array) -> Iterator[str]:
    """Mistakes with a number, which is estimated."""
    tolerances = rests.tolerances
    for factor in _scales(rests, position):
        if _fits(rests, position / factor, rotation):
            yield f"lengths are {factor:.3g} of the model's: is rod.length right?"
            break
    turn = _base_turn(rests, position, rotation)
    if turn is not None:
        yield f"{_turn(turn)}: is the base's frame turned?"
    fit = rests.fit(position, rotation, replace(tolerances, offset=FREE * tolerances.offset))
    if fit.is_tolerated and float(np.linalg.norm(fit.offset)) < FARTHEST * rests.length:
        yield f"base {_displacement(fit.offset)} off"
    fit = rests.fit(position, rotation, replace(tolerances, orientation=FREE * tolerances.orientation))
    if fit.is_tolerated:
        left = rotation_vectors(rotation @ _nearest_rotation(rests, fit).T)
        yield f"only its orientation is off, {_turn(left)}: do the markers' axes lie along the tip's?"


def _fits(rests: RestFamily, position: Array, rotation: Array) -> bool:
    return rests.may_fit(position) and rests.fit(position, rotation).is_tolerated


def _base_turn(rests: RestFamily, position: Array, rotation: Array) -> Array | None:
    """Return the turn of the base [rad], shape (3,), if that alone explains the rest.

    The fit holds for small turns: it is repeated on the pose turned back.
    """
    tolerances = replace(rests.tolerances, tilt=FREE * rests.tolerances.tilt)
    turned = np.eye(3)
    for _ in range(TURNS):
        fit = rests.fit(turned.T @ position, turned.T @ rotation, tolerances)
        turned = turned @ turn_by(fit.tilt)
    fit = rests.fit(turned.T @ position, turned.T @ rotation, tolerances)
    return rotation_vectors(turned) if fit.is_tolerated else None


def _scales(rests: RestFamily, position: Array) -> Iterator[float]:
    """Sizes against the model's under no, some and much weight."""
    size = float(np.linalg.norm(position))
    reach = np.linalg.norm(rests.positions, axis=1)
    for rest in (reach[0], float(np.median(reach)), float(np.min(reach))):
        yield size / float(rest)


def _nearest_rotation(rests: RestFamily, fit: Fit) -> Array:
    index = int(np.argmin(np.sum((rests.positions - fit.position) ** 2, axis=1)))
    return np.asarray(rests.rotations[index])


def _turn(vector: Array) -> str:
    """A rotation vector in words."""
    degrees = math.degrees(float(np.linalg.norm(vector)))
    axis = int(np.argmax(np.abs(vector)))
    if abs(vector[axis]) > 0.95 * float(np.linalg.norm(vector)):
        return f"rotated by {math.copysign(degrees, vector[axis]):.0f} degrees about {AXES[axis]}"
    x, y, z = vector / max(float(np.linalg.norm(vector)), 1e-12)
    return f"rotated by {degrees:.0f} degrees about ({x:.2f}, {y:.2f}, {z:.2f})"


def _displacement(vector: Array) -> str:
    """A displacement in words."""
    axis = int(np.argmax(np.abs(vector)))
    if abs(vector[axis]) > 0.9 * float(np.linalg.norm(vector)):
        return f"{vector[axis] * 1e3:+.0f} mm along {AXES[axis]}"
    x, y, z = vector * 1e3
    return f"({x:+.0f}, {y:+.0f}, {z:+.0f}) mm"


def _is_straight(rests: RestFamily, position: Array, rotation: Array) -> bool:
    """True if the tip is that of a straight rod, which no rest is."""
    straight = np.array([0.0, 0.0, rests.length])
    if float(np.min(np.linalg.norm(rests.positions - straight, axis=1))) < NEAR * rests.length:
        return False
    upright = float(np.linalg.norm(rotation_vectors(rotation))) < rests.tolerances.tilt
    return upright and float(np.linalg.norm(position - straight)) < NEAR * rests.length


def _unexplained(rests: RestFamily, position: Array, rotation: Array) -> str:
    """Describe a rest that no single mistake explains."""
    if float(np.linalg.norm(position)) < NEAR * rests.length:
        return "the tip is at the base: are the units right, or is it the base's own pose?"
    fit = rests.fit(position, rotation)
    return (
        f"nothing simple: tip {_displacement(position - fit.position)} from the nearest rest; is it another robot's "
        "pose, is the arm held, or a tendon still pulled?"
    )
