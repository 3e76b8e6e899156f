"""Feasibility of a planar reference: whether the servos can move the tendon as fast as it asks.

Servos are slower than the paper's experiment. References in space are slowed down by themselves, see `time_scaling`.
"""

import math

import numpy as np

from tendond.daemon.control.reference.trajectories import Trajectory
from tendond.model.rod.static_curve import Pair, StaticCurve
from tendond.schemas.config.control import LimitsSection

SAMPLES = 100
"""Samples of a trajectory; more would resolve the knots of the curve of resting tips."""


def displacement_rate_max(curve: StaticCurve, trajectory: Trajectory, arrival: float) -> float:
    """Return the largest displacement rate of the agonist for which the tip is on the reference [m/s].

    It is computed from the curve of resting tips: a tip in motion asks for somewhat more or less.

    Args:
        curve: tips of the resting rod.
        trajectory: trajectory of the reference; arrival: its time of arrival [s].
    """
    if arrival <= 0.0:
        return math.inf
    times = np.linspace(0.0, arrival, SAMPLES)
    arcs = curve.nearest(np.array([trajectory(time)[0] for time in times.tolist()]))
    displacement = np.interp(arcs, curve.arc, curve.displacement)
    return float(np.max(np.abs(np.diff(displacement)))) / float(times[1])


def feasibility(
    curve: StaticCurve, trajectory: Trajectory, arrival: float, target: Pair, limits: LimitsSection
) -> tuple[str, ...]:
    """Return a remark for the operator where `limits.displacement_rate` holds the tip back; nothing if it does not.

    Args:
        curve: tips of the resting rod.
        trajectory: trajectory of the reference; arrival: its time of arrival [s].
        target: final position across and along the straight rod [m].
        limits: [limits] of the configuration.
    """
    asked, allowed = displacement_rate_max(curve, trajectory, arrival), limits.displacement_rate
    if asked <= allowed or not allowed:  # zero: not yet derived from the robot
        return ()
    displacement = float(np.interp(curve.nearest(np.array([target]))[0], curve.arc, curve.displacement))
    pace = "at once" if math.isinf(asked) else f"at up to {asked * 1e3:.0f} mm/s"
    return (
        f"the tip will be late: the reference asks to move the tendon {pace}, limits.displacement_rate is "
        f"{allowed * 1e3:.0f} mm/s, and its {abs(displacement) * 1e3:.0f} mm take at least "
        f"{abs(displacement) / allowed:.2f} s",
    )
