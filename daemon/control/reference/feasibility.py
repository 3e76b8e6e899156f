"""Whether the tendon can be wound as fast as a reference asks; servos are slower than the paper's experiment."""

import math

import numpy as np

from tendond.daemon.control.reference.planar import Reference
from tendond.daemon.control.reference.spatial import Course
from tendond.schemas.config.control import LimitsSection

SAMPLES = 100
"""Of a course; finer ones see the grain of the curve of resting tips."""


def fastest_winding(reference: Reference) -> float:
    """Speed at which the agonist's end would have to be wound [m/s], at most, for the tip to be on the reference.

    Reckoned from the curve of resting tips: a tip in motion asks for somewhat more or less.
    """
    if reference.arrival <= 0.0:
        return math.inf
    times = np.linspace(0.0, reference.arrival, SAMPLES)
    arcs = reference.curve.nearest(np.array([reference.course(time)[0] for time in times.tolist()]))
    displacement = np.interp(arcs, reference.curve.arc, reference.curve.displacement)
    return float(np.max(np.abs(np.diff(displacement)))) / float(times[1])


def feasibility(reference: Reference | Course, limits: LimitsSection) -> str:
    """What to tell an operator of a reference that `limits.displacement_rate` holds back; empty if it does not.

    A course in space is slowed down by itself, and says so.
    """
    if isinstance(reference, Course):
        return ""
    asked, allowed = fastest_winding(reference), limits.displacement_rate
    if asked <= allowed:
        return ""
    across, along = reference.curve.axes
    target = np.array([[reference.target[across], reference.target[along]]])
    way = float(np.interp(reference.curve.nearest(target)[0], reference.curve.arc, reference.curve.displacement))
    pace = "at once" if math.isinf(asked) else f"at up to {asked * 1e3:.0f} mm/s"
    return (
        f"the tip will be late: the reference asks to wind the tendon {pace}, limits.displacement_rate is "
        f"{allowed * 1e3:.0f} mm/s, and its {abs(way) * 1e3:.0f} mm take {abs(way) / allowed:.2f} s at least"
    )
