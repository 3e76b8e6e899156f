"""From a wanted acceleration of the tip in the bending plane to the tension that brings it about."""

import numpy as np

from tendond.daemon.laws.law import Array, Observation

SMALLEST_GAIN = 1.0
"""[m/s^2/N] b_c vanishes as the rod straightens; below this size its inverse is not let grow any further."""


def in_plane(observation: Observation, vector: Array) -> Array:
    """The two components in the bending plane, shape (2,)."""
    return vector[list(observation.axes)]


def net_tension(observation: Observation, acceleration: Array) -> float:
    """Agonist minus antagonist tension [N] that gives the tip `acceleration` [m/s^2], shape (2,), in the plane.

    The paper's U = b_c^+ (-a_c + ...), with a_c = acceleration now - b_c U_applied: incremental, which is its integral
    action. b_c^+ = b'/(b'b) of the agonist's column; the paper writes 1/b_c and leaves open how a column is inverted.
    """
    gain = in_plane(observation, observation.input_gain[:, observation.agonist])
    missing = acceleration - in_plane(observation, observation.acceleration)
    applied = observation.tension[observation.agonist]
    if observation.antagonist is not None:
        applied -= observation.tension[observation.antagonist]
    return float(applied + gain @ missing / max(float(gain @ gain), SMALLEST_GAIN**2))


def share(observation: Observation, net: float) -> Array:
    """Tensions [N], shape (n,), whose difference across the agonist pair is `net`; the others are slack."""
    tension = np.zeros_like(observation.tension)
    tension[observation.agonist] = net if observation.antagonist is None else max(net, 0.0)
    if observation.antagonist is not None:
        tension[observation.antagonist] = max(-net, 0.0)
    return tension
