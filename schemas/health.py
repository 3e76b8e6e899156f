"""Parts of the controller's status: its loop, each sensor, and its filter."""

import math

from pydantic import Field

from tendond.schemas.base import Quaternion, Schema, Vector3

Six = tuple[float, float, float, float, float, float]

CONSISTENCY_MARKED = 4.0
"""Consistency above which it is marked: what is measured is twice as far from the estimate as the filter expects."""


class LoopHealth(Schema):
    """State of the fixed-rate loop since its start.

    Attributes:
        cycles: number of cycles.
        missed_ticks: deadlines that passed before the loop was ready for them; skipped, never repeated.
        cycle_ms_median, cycle_ms_p99: time from wake-up to command [ms], over the last seconds; without the work done
            before the deadline.
        log_dropped: log entries that did not fit the recorder's queue.
        log_error: error that ended the log; empty without one.
        phase_locked: the deadlines follow the phase of the poses.
        pose_wait_ms_median: time from the arrival of a pose to its cycle [ms], over the last seconds; none while
            unknown.
        log_days_left: days until the disk is full or the oldest logs are removed, at the recent rate; none while
            unknown.
    """

    cycles: int
    missed_ticks: int
    cycle_ms_median: float
    cycle_ms_p99: float
    log_dropped: int
    log_error: str = ""
    log_days_left: float | None = None
    phase_locked: bool = False
    pose_wait_ms_median: float | None = None

    @property
    def phase_in_words(self) -> str:
        """Phase of the loop against the poses, for people."""
        if not self.phase_locked:
            return "free: the poses keep no phase to follow"
        waits = "" if self.pose_wait_ms_median is None else f", a pose waits {self.pose_wait_ms_median:.2f} ms"
        return f"locked to the poses{waits}"


class SensorHealth(Schema):
    """Readings of one sensor, as the controller admits them.

    Attributes:
        rate: cycles with a reading per second [Hz], of the last dozen readings; none before the second one.
        age: time since the newest reading arrived [s]; none before the first.
        silent: none has come for the sensor's `timeout`.
        objection: reason against the newest reading; empty where it was admitted.
    """

    rate: float | None
    age: float | None
    silent: bool
    objection: str = ""

    @property
    def in_words(self) -> str:
        """Rate or silence, for people: '99.8 Hz', 'silent for 1.2 s: out of order'."""
        if not self.silent:
            text = "its first reading" if self.rate is None else f"{self.rate:.3g} Hz"
        else:
            text = "no reading yet" if self.age is None else f"silent for {self.age:.3g} s"
        return f"{text}: {self.objection}" if self.objection else text


class ContactHealth(Schema):
    """A force on the body that the estimator found; in the base's frame.

    Attributes:
        place: arc length from the base [m]. first_place, last_place: ends of those that the data do not exclude [m].
        force: [N]. force_deviation: standard deviation of each component [N].
    """

    place: float
    first_place: float
    last_place: float
    force: Vector3
    force_deviation: Vector3

    @property
    def in_words(self) -> str:
        """Force and place, for people: '0.21±0.03 N at 312 mm (280 to 340)'."""
        size, deviation = math.hypot(*self.force), max(self.force_deviation)
        places = f"{1e3 * self.place:.0f} mm ({1e3 * self.first_place:.0f} to {1e3 * self.last_place:.0f})"
        return f"{size:.2f}±{deviation:.2f} N at {places}"


class FilterHealth(Schema):
    """What an observer of kind 'kalman' knows, and how sure it is.

    Attributes:
        force: size of the force on the tip [N]; force_deviation: its standard deviation [N].
        tip_bound: largest half axis of the ellipsoid that holds the tip with 95 % [m].
        stiffness: of the robot, relative to that configured [-]; stiffness_deviation: its standard deviation [-].
        consistency: mean square of the innovations over a second, in units of their expected spread [-]; 1 is right.
        contact: force on the body that was found; left out where there is none, or none is sought.
        tip_mass: on the tip beside that configured [kg]; tip_mass_deviation: its standard deviation [kg]; left out
            where it is taken as known.
        force_vector: on the tip [N], in the base's frame. tip_covariance, force_covariance: of tip and force, xx, xy,
            xz, yy, yz, zz [m^2, N^2]; for viewers, left out by earlier versions.
        tip: position of the estimated tip [m], tip_orientation: w, x, y, z; in the base's frame, for viewers, left out
            by earlier versions.
    """

    force: float
    force_deviation: float
    tip_bound: float
    stiffness: float
    stiffness_deviation: float
    consistency: float
    contact: ContactHealth | None = Field(None, exclude_if=lambda value: value is None)
    force_vector: Vector3 | None = Field(None, exclude_if=lambda value: value is None)
    tip_covariance: Six | None = Field(None, exclude_if=lambda value: value is None)
    force_covariance: Six | None = Field(None, exclude_if=lambda value: value is None)
    tip: Vector3 | None = Field(None, exclude_if=lambda value: value is None)
    tip_orientation: Quaternion | None = Field(None, exclude_if=lambda value: value is None)
    tip_mass: float | None = Field(None, exclude_if=lambda value: value is None)
    tip_mass_deviation: float | None = Field(None, exclude_if=lambda value: value is None)

    @property
    def is_inconsistent(self) -> bool:
        """True if it is less sure than it claims to be."""
        return self.consistency > CONSISTENCY_MARKED

    @property
    def force_in_words(self) -> str:
        """Force with its deviation, and the consistency, for people."""
        mark = f" > {CONSISTENCY_MARKED:g}" if self.is_inconsistent else ""
        return f"{self.force:.2f}±{self.force_deviation:.2f} N, consistency {self.consistency:.1f}{mark}"

    @property
    def tip_in_words(self) -> str:
        """Bound of the tip, and stiffness and mass with their deviations, for people."""
        known = f"{1e3 * self.tip_bound:.1f} mm, stiffness {self.stiffness:.2f}±{self.stiffness_deviation:.2f}"
        if self.tip_mass is None or self.tip_mass_deviation is None:
            return known
        return f"{known}, mass {1e3 * self.tip_mass:+.1f}±{1e3 * self.tip_mass_deviation:.1f} g"

    @property
    def in_words(self) -> str:
        """All of it: 'force 0.30±0.03 N, consistency 1.0, tip (95 %) within 2.5 mm, stiffness 1.01±0.01'."""
        touched = "" if self.contact is None else f", contact {self.contact.in_words}"
        return f"force {self.force_in_words}, tip (95 %) within {self.tip_in_words}{touched}"
