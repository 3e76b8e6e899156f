"""The check of the sensors beside the camera."""

import numpy as np

from tendond.cli.doctor.check import CheckResult, Rig, failed, passed, warned
from tendond.schemas.config.sensors.section import SensorSection
from tendond.schemas.messages import SensorReading


def sensors(rig: Rig) -> CheckResult | None:
    """Check that each configured sensor is heard with the rows that it should have, and no other one is."""
    activity, sections = rig.activity, rig.config.sensors
    names = {one.name for one in sections}
    strangers = sorted(activity.readings.keys() - names)
    if not (sections or strangers):
        return None
    if not activity.connected:
        return warned("not checked: the controller is not running", "start it, then run this again")
    rates = {one.name: _rate(activity.readings.get(one.name, [])) for one in sections}
    finding = ", ".join(f"{name} {'silent' if rate is None else f'{rate:.0f} Hz'}" for name, rate in rates.items())
    if strangers:
        finding += f"{'; ' if finding else ''}not in [[sensors]]: {', '.join(strangers)}"
    wrong = [text for one in sections if (text := _misfit(one, activity.readings.get(one.name, [])))]
    wrong += [f"unreadable: {count} {reason}" for reason, count in activity.unreadable_readings.items()]
    if wrong:
        return failed("; ".join([finding, *wrong]), "make the driver publish what [[sensors]] says, or correct that")
    silent = [one for one in sections if rates[one.name] is None]
    if silent or strangers:
        said = failed if any(one.required for one in silent) else warned
        return said(finding, f"start the driver, which publishes on {rig.config.rig.name}/sensor/<name>")
    return passed(finding)


def _rate(readings: list[tuple[int, SensorReading]]) -> float | None:
    """Return readings per second; none of fewer than two."""
    arrivals = np.array([arrival for arrival, _ in readings]) * 1e-9
    return (len(arrivals) - 1) / max(float(arrivals[-1] - arrivals[0]), 1e-9) if len(arrivals) > 1 else None


def _misfit(section: SensorSection, readings: list[tuple[int, SensorReading]]) -> str:
    """Say what the newest reading has, where it is not what is configured; empty where it is."""
    rows = readings[-1][1].rows if readings else ()
    widths = {len(row) for row in rows if row is not None} - {section.width}
    if not readings or (len(rows) == section.rows and not widths):
        return ""
    found = f"{len(rows)} rows" + (f" of {min(widths)} numbers" if widths else "")
    return f"{section.name} has {found}, where {section.rows} of {section.width} are configured"
