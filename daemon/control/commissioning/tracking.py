"""Watches during tracking: the tip arrives, nothing keeps swinging, pose and model agree.

The observer pulls the model's tip onto whatever is measured, so their distance shows little. What it cannot pull away
is kept here: the distance of the tip from its reference, swings of tip and command that do not die down, an orientation
that is not that of the model in the measured place, and a tip that jumps between two poses and rests before and after.
With these numbers `tendond study robustness` has no false alarm.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tendond.daemon.control.commissioning.swing import Swing
from tendond.schemas.base import Quaternion, Vector3
from tendond.schemas.config.rig import RigConfig

REST_SPEED = 0.01
"""Speed below which a reference rests, of the rod's length per second. Chosen; `tendond study robustness` has no false
alarm with it."""

MOVING = 2.5
"""Factor on the tolerated distance and swing while the reference moves. Chosen; `tendond study robustness` has no false
alarm with it, nor has `pytest tests/unit/control/monitors -k however_fast`."""


@dataclass(frozen=True)
class TrackingBounds:
    """Tolerances during tracking; times in cycles.

    Attributes:
        period: period of the cycle [s]. length: length of the rod [m].
        error: distance of the tip from its reference [m]; error_time: time for which it may be larger.
        swing, tension_swing: size of a sustained swing of tip [m] and command [N].
        orientation: angle between the measured and the model's tip [rad]; orientation_time: time for which it may be
            larger.
        jump: step of the tip between two poses [m].
        load_max: largest reported tension [N]; load_excess: excess of a reported tension over twice the model's [N].
        displacement_min, displacement_max: range of a reported displacement [m].
        report_time: time for which reports may be beyond.
        pose_age_max: age of a pose [s]; pose_age_time: time for which poses may be older.
    """

    period: float
    length: float
    error: float
    error_time: int
    swing: float
    tension_swing: float
    orientation: float
    orientation_time: int
    jump: float
    load_max: float
    load_excess: float
    displacement_min: float
    displacement_max: float
    report_time: int
    pose_age_max: float
    pose_age_time: int

    @staticmethod
    def from_config(config: RigConfig) -> "TrackingBounds":
        """The bounds of a configuration."""
        faults, limits, period, length = config.faults, config.limits, config.loop.period, config.rod.length
        margin = 0.25 * (limits.displacement_max - limits.displacement_min)

        def cycles(seconds: float) -> int:
            return max(1, round(seconds / period))

        return TrackingBounds(
            period=period,
            length=length,
            error=faults.tracking_error * length,
            error_time=cycles(faults.tracking_time),
            swing=faults.swing * length,
            tension_swing=faults.tension_swing * limits.tension_max,
            orientation=faults.orientation,
            orientation_time=cycles(faults.orientation_time),
            jump=faults.jump * length,
            load_max=(1.0 + faults.load_margin) * limits.tension_max,
            load_excess=faults.load_margin * limits.tension_max,
            displacement_min=limits.displacement_min - margin,
            displacement_max=limits.displacement_max + margin,
            report_time=cycles(faults.report_time),
            pose_age_max=config.observer.delay + faults.pose_age,
            pose_age_time=cycles(faults.age_time),
        )


@dataclass(frozen=True)
class TrackingWatch:
    """Observations since tracking began.

    Attributes:
        error_cycles: cycles at more than the tolerated distance; error: that distance now [m].
        tip_swings: swings of the tip's coordinates about its reference, since that last started, stopped or turned.
        tension_swings: swings of each tendon's command.
        heading: velocity of the reference in the cycle before [m/s]; zeros where it rested.
        orientation_cycles: cycles at more than the tolerated angle; angle: now [rad].
    """

    error_cycles: int = 0
    error: float = 0.0
    tip_swings: tuple[Swing, ...] = ()
    tension_swings: tuple[Swing, ...] = ()
    heading: Vector3 = (0.0, 0.0, 0.0)
    orientation_cycles: int = 0
    angle: float = 0.0


def watch_tracking(
    bounds: TrackingBounds,
    watch: TrackingWatch,
    tick: int,
    interval: int,
    measured: Vector3,
    reference: Vector3,
    reference_velocity: Vector3,
    commanded: Sequence[float],
    angle: float | None,
) -> TrackingWatch:
    """Return the watch after a cycle with a fresh pose; pure.

    Args:
        bounds: bounds of what is tolerated. watch: so far. tick: present cycle. interval: cycles since the last pose.
        measured: tip [m]. reference: [m]. reference_velocity: [m/s].
        commanded: tensions [N].
        angle: between the measured tip and the model's there [rad]; none where the model is not held to it.
    """
    rests = math.hypot(*reference_velocity) < REST_SPEED * bounds.length
    factor = 1.0 if rests else MOVING
    apart = [a - b for a, b in zip(measured, reference, strict=True)]
    error = math.hypot(*apart)
    heading = (0.0, 0.0, 0.0) if rests else reference_velocity
    # A reference that starts, stops or turns back makes the arm sway: what it excites is no limit cycle of the loop.
    along = sum(a * b for a, b in zip(heading, watch.heading, strict=True))
    excited = along < 0.0 or (rests is not (math.hypot(*watch.heading) == 0.0))
    tip, tension = (() if excited else watch.tip_swings) or (Swing(),) * 3, watch.tension_swings
    tip = tuple(one.add(value, tick, factor * bounds.swing) for one, value in zip(tip, apart, strict=True))
    if rests:
        tension = tension or (Swing(),) * len(commanded)
        tension = tuple(
            one.add(value, tick, bounds.tension_swing) for one, value in zip(tension, commanded, strict=True)
        )
    else:  # a reference that moves moves the command
        tension = ()
    turned = angle is not None and angle > bounds.orientation
    return TrackingWatch(
        error_cycles=watch.error_cycles + interval if error > factor * bounds.error else 0,
        error=error,
        tip_swings=tip,
        tension_swings=tension,
        heading=heading,
        orientation_cycles=watch.orientation_cycles + interval if turned else 0,
        angle=angle or 0.0,
    )


def tracking_fault(bounds: TrackingBounds, watch: TrackingWatch, saturated: bool) -> str:
    """Return the reason to end tracking; empty if there is none.

    Args:
        bounds: bounds of what is tolerated. watch: so far.
        saturated: the command stands at a limit.
    """
    if watch.error_cycles >= bounds.error_time:
        cause = "the command is at a limit" if saturated else "the commands have been there for long"
        seconds = watch.error_cycles * bounds.period
        return (
            f"tracking error: the tip is {watch.error * 1e3:.0f} mm from its reference for "
            f"{seconds:g} s, and {cause}; is the arm held, or the rig another than configured?"
        )
    if watch.orientation_cycles >= bounds.orientation_time:
        return (
            f"orientation: the measured tip is turned by {math.degrees(watch.angle):.0f} degrees against the model's "
            f"in the same place, for {watch.orientation_cycles * bounds.period:g} s; have markers or camera moved?"
        )
    for axis, swing in zip("xyz", watch.tip_swings, strict=False):
        if (found := swing.sustained(bounds.period)) is not None:
            return (
                f"limit cycle: the tip swings by {found[0] * 1e3:.0f} mm in {axis} at {found[1]:.1f} Hz and does not "
                "settle; lower observer.integral, or set observer.delay and rod.tip_mass"
            )
    for index, swing in enumerate(watch.tension_swings):
        if (found := swing.sustained(bounds.period)) is not None:
            return (
                f"limit cycle: the command of tendon {index} swings by {found[0]:.1f} N at {found[1]:.1f} Hz and does "
                "not settle; lower observer.integral, or set observer.delay and rod.tip_mass"
            )
    return ""


def tip_angle(one: Quaternion, other: Quaternion) -> float:
    """Angle between two orientations [rad]."""
    dot = abs(sum(a * b for a, b in zip(one, other, strict=True)))
    return 2.0 * math.acos(min(1.0, dot))
