"""The check of the rest before arming: the measured tip against those that a right rig may have."""

import numpy as np

from tendond.daemon.control.commissioning.averages import RestWatch
from tendond.daemon.control.commissioning.mistakes import likely_mistakes
from tendond.daemon.control.commissioning.rests import RestFamily
from tendond.daemon.control.commissioning.rotations import rotation_matrix, rotation_vectors


def rest_objection(rests: RestFamily, watch: RestWatch) -> str:
    """Say that the measured rest is not one of a right rig, and the likely mistake; empty if it is one.

    Args:
        rests: rests of right rigs. watch: watch of the tip while no tendon pulls.
    """
    best = watch.best
    if best is None:
        return "the tip has not been seen at rest yet: ask again in a moment"
    position, orientation = best.mean, best.mean_orientation
    rotation = rotation_matrix(orientation)
    fit = rests.fit(position, rotation)
    if fit.is_tolerated:
        return ""
    if moved := watch.moved(rests.length):
        return f"the tip is moving (by {moved * 1e3:.0f} mm in a quarter of a second): wait until it rests"
    guesses = "; or: ".join(likely_mistakes(rests, position, orientation))
    nearest = int(np.argmin(np.sum((rests.positions - position) ** 2, axis=1)))
    apart = float(np.linalg.norm(rests.positions[nearest] - position)) * 1e3
    turned = np.degrees(np.linalg.norm(rotation_vectors(rotation @ rests.rotations[nearest].T)))
    x, y, z = position * 1e3
    return (
        f"the arm does not rest as the model does: tip at ({x:.0f}, {y:.0f}, {z:.0f}) mm, {apart:.0f} mm and "
        f"{turned:.0f} degrees from the nearest rest; {guesses}"
    )
