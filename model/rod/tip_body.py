"""The body of a weight on the tip, by its mass alone."""

import math

BALL_DENSITY = 8500.0
"""[kg/m^3] Of brass, of which laboratory weights are made."""


def ball_inertia(mass: float) -> tuple[float, float, float]:
    """Inertia of a brass ball about its centre [kg m^2], for a mass [kg]: 2/5 m r^2."""
    radius = (3.0 * mass / (4.0 * math.pi * BALL_DENSITY)) ** (1.0 / 3.0)
    inertia = 0.4 * mass * radius * radius
    return inertia, inertia, inertia
