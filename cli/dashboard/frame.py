"""Frame of the page: what it shows, as JSON; numbers in SI, words as `tendond watch` writes them."""

import math
from typing import Any

from rich.text import Text

from tendond.cli.watch.bus_snapshot import BusSnapshot, Stream
from tendond.cli.watch.health import BAD, LABEL, WARN, health_rows
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, Status
from tendond.schemas.remedies import SENTENCES, clearing

Frame = dict[str, Any]

TENSION_MAX = "limits.tension_max"


def frame(snapshot: BusSnapshot, config: RigConfig, now: float, option: str = "") -> Frame:
    """Return what the page shows of a snapshot.

    Args:
        snapshot: of the bus.
        config: of the rig, for its limits.
        now: time on the clock of the snapshot [s].
        option: that names the rig, in the command that clears a fault.
    """
    status = snapshot.status
    shown: Frame = {
        "now": now,
        "silent": status is None or snapshot.is_silent(now),
        "pose": {**_stream(snapshot.pose_stream, now), "valid": snapshot.pose is not None and snapshot.pose.valid},
        "command_stream": _stream(snapshot.command_stream, now),
        "tendons_stream": _stream(snapshot.tendons_stream, now),
        "error": snapshot.error,
        "tip": None if snapshot.pose is None else snapshot.pose.position,
    }
    if status is not None:
        shown |= _of_status(status, config, option)
    if snapshot.command is not None:
        command = snapshot.command
        shown |= {
            "seq": command.seq,
            "tension": command.tension,
            "displacement": command.displacement,
            "armed": command.armed,
        }
    if (tendons := snapshot.tendons) is not None:
        shown |= {"servo_fault": tendons.fault, "measured": tendons.displacement, "measured_tension": tendons.tension}
    return shown


def _of_status(status: Status, config: RigConfig, option: str) -> Frame:
    tuned = status.tuned.get(TENSION_MAX)
    fault = status.mode is Mode.FAULT
    return {
        "mode": status.mode.value,
        "sentence": SENTENCES[status.mode],
        "reason": status.reason,
        "remedy": clearing(status.reason, option, has_servos=config.servo is not None) if fault else "",
        "law": status.law,
        "feedback": status.feedback,
        "tick": status.tick,
        "target": status.target,
        "tension": status.tension,
        "displacement": status.displacement,
        "tension_max": config.limits.tension_max if tuned is None else tuned.value,
        "missed": status.loop.missed_ticks,
        "cycle_ms": status.loop.cycle_ms_median,
        "cycle_ms_p99": status.loop.cycle_ms_p99,
        "filter": status.filter is not None,
        "rows": [_row(row) for row in health_rows(status)],
    }


def _stream(stream: Stream, now: float) -> Frame:
    """Return age [s], none before the first message, and rate [Hz]."""
    return {"age": None if math.isinf(stream.at) else now - stream.at, "rate": stream.rate(now)}


def _row(row: Text) -> list[str]:
    """Return label, value, and "bad", "warn" or nothing."""
    styles = {str(span.style) for span in row.spans}
    return [
        row.plain[:LABEL].strip(),
        row.plain[LABEL:].strip(),
        "bad" if BAD in styles else "warn" if WARN in styles else "",
    ]
