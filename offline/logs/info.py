"""Content and condition of a log, for `tendond log info`."""

from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from mcap.records import Channel, Footer, Message

from tendond.daemon.recording.channels import CYCLE, STATE, TIMING
from tendond.offline.logs.container import Damage, records
from tendond.offline.logs.run import Run, no_cycles, open_run
from tendond.offline.logs.ticks import left_out_before
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord, LoopTiming
from tendond.schemas.remedies import clearing


def info(path: Path) -> dict[str, Any]:
    """Summarise the contents and health of a log, damaged or not, in JSON types.

    Keys: files, bytes, complete, damage (texts), metadata, calibration (of the servos; null without), started (UTC),
    duration_s, messages (by topic), cycles, first_tick, last_tick, missing_ticks (in the log), left_out (of the log on
    purpose, while the arm was idle), missed_deadlines (of the loop), modes (tick, mode, reason at each change), faults
    (tick, reason, to_clear: the commands that do), rejected (inputs, by reason), readings (of sensors, by name),
    snapshots.

    Raises:
        LogError: not one of ours, without configuration, without one cycle that can be read, or of another version.
    """
    run = open_run(path)
    counts: Counter[str] = Counter()
    rejected: Counter[str] = Counter()
    readings: Counter[str] = Counter({sensor.name: 0 for sensor in run.config.sensors})
    modes: list[dict[str, Any]] = []
    damage: list[str] = []
    ticks: list[int] = []
    times: list[int] = []
    missed, left_out, complete = 0, 0, False
    for file in run.paths:
        topics: dict[int, str] = {}
        complete = False
        for record in records(file):
            match record:
                case Damage():
                    damage.append(f"{file.name}: {record}")
                case Channel():
                    topics[record.id] = record.topic
                    counts[record.topic] += 0
                case Footer():
                    complete = True
                case Message():
                    topic = topics.get(record.channel_id, "")
                    counts[topic] += 1
                    if topic == CYCLE.topic:
                        cycle = run.decode(topic, CycleRecord, record.data)
                        ticks.append(cycle.tick)
                        times.append(record.log_time)
                        rejected.update(cycle.rejected)
                        readings.update(cycle.inputs.readings.keys())
                        if not modes or modes[-1]["mode"] != cycle.mode.value:
                            modes.append({"tick": cycle.tick, "mode": cycle.mode.value, "reason": cycle.reason})
                    elif topic == STATE.topic and ticks and (stretch := left_out_before(record.data)) is not None:
                        left_out += stretch[1] - stretch[0] + 1
                    elif topic == TIMING.topic:
                        missed += run.decode(topic, LoopTiming, record.data).missed_ticks
    if not ticks:
        raise no_cycles(path, complete=complete)
    return {
        "files": [str(file) for file in run.paths],
        "bytes": sum(file.stat().st_size for file in run.paths),
        "complete": complete,
        "damage": damage,
        "metadata": run.metadata,
        "calibration": None if run.calibration is None else run.calibration.model_dump(mode="json"),
        "started": datetime.fromtimestamp(times[0] / 1e9, UTC).isoformat(timespec="seconds"),
        "duration_s": _duration(run, ticks),
        "messages": dict(counts),
        "cycles": len(ticks),
        "first_tick": ticks[0],
        "last_tick": ticks[-1],
        "missing_ticks": ticks[-1] - ticks[0] + 1 - len(ticks) - left_out,
        "left_out": left_out,
        "missed_deadlines": missed,
        "modes": modes,
        "faults": [
            change | {"to_clear": clearing(change["reason"], has_servos=run.config.servo is not None)}
            for change in modes
            if change["mode"] == Mode.FAULT.value
        ],
        "rejected": dict(rejected),
        "readings": dict(readings),
        "snapshots": counts["state"],
    }


def _duration(run: Run, ticks: list[int]) -> float:
    """Compute the nominal duration of the cycles, without missed deadlines [s]."""
    return round((ticks[-1] - ticks[0] + 1) * run.config.loop.period, 6)
