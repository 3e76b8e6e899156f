"""Tendons of a run with servos: commanded and reported displacements, and what limits the speed."""

from dataclasses import dataclass

import numpy as np
from rich.table import Table

from tendond.offline.logs.log import Array, LogFile
from tendond.schemas.messages import Mode, ServoHealth

LAGS = 40
"""Maximum lag of the servos, in cycles."""

RESTING = 1e-3
"""Speed below which a tendon is taken to be at rest [m/s]."""


@dataclass(frozen=True)
class WireTraces:
    """Measures of one tendon while the rig was armed.

    Attributes:
        travel: travel of the command [m].
        lag: lag that fits the reports to the commands best [s]: command, serial line, servo and line back.
        error: largest difference from the command of that time [m]; still: at the end [m].
        rate: fastest command [m/s].
        tension: largest that the servo reported [N], load: of its stall torque [-].
        motor: rate that the motor has left at that load, by its speed and torque [m/s].
    """

    travel: float
    lag: float
    error: float
    still: float
    rate: float
    tension: float
    load: float
    motor: float


def wires(log: LogFile) -> list[WireTraces]:
    """Measure each tendon of a run with servos that reported.

    Returns:
        One for each tendon; none where no servo reported anything, or the rig was never armed.
    """
    armed = [
        record
        for record in log.records
        if record.mode in (Mode.PRETENSION, Mode.TRACKING) and record.inputs.tendon_state is not None
    ]
    if len(armed) < 2 * LAGS or log.config.servo is None:
        return []
    states = [record.inputs.tendon_state for record in armed]
    commanded = np.array([record.command.displacement for record in armed])
    reported = np.array([state.displacement for state in states if state is not None])
    tensions = np.array([state.tension for state in states if state is not None])
    period = log.config.loop.period
    passed = np.diff([record.tick for record in armed]) * period  # a cycle without a report is left out
    radius, servo = log.config.servo.spool_radius, log.config.servo.motor
    found = []
    for tendon in range(commanded.shape[1]):
        lag, error = _lag(commanded[:, tendon], reported[:, tendon])
        tension = float(tensions[:, tendon].max())
        load = tension * radius / servo.torque_max
        found.append(
            WireTraces(
                travel=float(np.ptp(commanded[:, tendon])),
                lag=lag * period,
                error=error,
                still=abs(float(reported[-1, tendon] - commanded[-1, tendon])),
                rate=float(np.abs(np.diff(commanded[:, tendon]) / passed).max()),
                tension=tension,
                load=load,
                motor=servo.no_load_speed * max(0.0, 1.0 - load) * radius,
            )
        )
    return found


def _lag(commanded: Array, reported: Array) -> tuple[int, float]:
    """Find the lag of one curve behind the other [cycles], and the largest remaining difference."""
    errors = [
        float(np.sqrt(np.mean((reported[LAGS:] - commanded[LAGS - lag : len(commanded) - lag]) ** 2)))
        for lag in range(LAGS)
    ]
    lag = int(np.argmin(errors))
    left = np.abs(reported[LAGS:] - commanded[LAGS - lag : len(commanded) - lag])
    return lag, float(left.max())


def pace(log: LogFile, tendons: list[WireTraces]) -> str:
    """Say in a sentence what limits the speed."""
    section = log.config.servo
    if section is None or not tendons:
        return ""
    one = max(tendons, key=lambda each: each.rate)
    allowed = min(log.config.limits.displacement_rate, section.displacement_rate)
    free = section.motor.no_load_speed * section.spool_radius
    return (
        f"The servos limit the speed: {one.travel * 1e3:.1f} mm of tendon take {one.travel / free:.2f} s at the"
        f" {free * 1e3:.1f} mm/s that they have without load, {one.travel / allowed:.2f} s at the"
        f" {allowed * 1e3:.0f} mm/s that are allowed; the maximum command was {one.rate * 1e3:.0f} mm/s,"
        f" and {one.motor * 1e3:.0f} mm/s are left at the largest load."
    )


def wires_table(tendons: list[WireTraces], health: ServoHealth | None) -> Table:
    """Write the table."""
    table = Table(title="Wires: commanded and reported displacements")
    for heading in (
        "tendon",
        "travel",
        "lag",
        "error without lag",
        "error at the end",
        "fastest",
        "tension",
        "load",
    ):
        table.add_column(heading, justify="right")
    for number, one in enumerate(tendons):
        moved = one.rate > RESTING
        table.add_row(
            str(number),
            f"{one.travel * 1e3:.1f} mm",
            f"{one.lag * 1e3:.0f} ms" if moved else "-",
            f"{one.error * 1e3:.2f} mm",
            f"{one.still * 1e3:.2f} mm",
            f"{one.rate * 1e3:.0f} mm/s",
            f"{one.tension:.1f} N",
            f"{one.load:.0%}",
        )
    if health is not None:
        table.caption = (
            f"serial line: {health.reads} reads of all servos, {health.lost} lost, {health.late} replies late;"
            f" {health.round_trip * 1e3:.1f} ms round trip, {health.round_trip_max * 1e3:.1f} ms maximum"
        )
    return table
