"""A log file in a few numbers, by its head, its summary and its messages for people; the cycles are not read."""

import json
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Footer, Message

from tendond.daemon.recording.channels import CYCLE, LOG
from tendond.daemon.recording.foxglove import Log, LogLevel
from tendond.offline.logs.container import LogError, records
from tendond.offline.logs.run import decode, open_run, part_of
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.messages import Mode

FAULT = f"{Mode.FAULT.value}: "
"""Beginning of the message for people on a fault."""

_MODE = re.compile(rb'^\{"version":\d+,"tick":\d+,"time":[^,]+,"mode":"(\w+)","reason":("(?:[^"\\]|\\.)*")')
"""Mode and reason of a recorded cycle, without reading the rest of it."""


@dataclass(frozen=True)
class ScannedFile:
    """One file of a run.

    Attributes:
        run: name of its run; the file's own where the file cannot be read.
        part: its number in the run, from 0.
        rig, law, reference: of the configuration that is attached.
        begun, ended: first and last entry [ns since 1970, UTC]; 0 without entries.
        cycles: number of cycles.
        faults: reason of each fault, in order.
        complete: it was finished.
        problem: why it cannot be read, in one line; empty if it can.
    """

    run: str
    part: int = 0
    rig: str = ""
    law: str = ""
    reference: str = ""
    begun: int = 0
    ended: int = 0
    cycles: int = 0
    faults: tuple[str, ...] = ()
    complete: bool = False
    problem: str = ""


def scan(path: Path) -> ScannedFile:
    """Read what is listed of a file; never raises for what is in it."""
    try:
        run = open_run(path, whole=False)
        begun, ended, cycles, faults, complete = _finished(path) or _unindexed(path)
    except LogError as error:
        return ScannedFile(path.stem, problem=str(error).removeprefix(f"{path}: "))
    config = run.config
    return ScannedFile(
        run=run.name,
        part=part_of(run.metadata),
        rig=run.metadata.get("rig", config.rig.name),
        law=config.control.law,
        reference=in_words(config.reference),
        begun=begun,
        ended=ended,
        cycles=cycles,
        faults=faults,
        complete=complete,
    )


def in_words(reference: ReferenceSection) -> str:
    """Describe a reference in a few words: 'minimum_jerk to x 0.34 m'."""
    target = ""
    if reference.across is not None:
        target = f" to {reference.across:g} m across"
    elif reference.position is not None:
        target = " to ({:g}, {:g}, {:g}) m".format(*reference.position)
    elif reference.angle is not None:
        target = f" to {reference.angle:g} rad"
    return f"{reference.kind}{target}"


Found = tuple[int, int, int, tuple[str, ...], bool]
"""First and last entry [ns], cycles, faults, and whether the file is finished."""


def _finished(path: Path) -> Found | None:
    """Read the summary of a file, and its messages for people by the index; none where there is neither."""
    with suppress(McapError, OSError, ValueError), path.open("rb") as stream:
        reader = make_reader(stream)
        summary = reader.get_summary()
        if summary is None or summary.statistics is None:
            return None
        found = summary.statistics
        counts = {one.topic: found.channel_message_counts.get(number, 0) for number, one in summary.channels.items()}
        if not counts.get(LOG.topic):
            return None
        lines = [message.data for _, _, message in reader.iter_messages(topics=[LOG.topic])]
        faults = _faults_of_lines(path, lines)
        return found.message_start_time, found.message_end_time, counts.get(CYCLE.topic, 0), faults, True
    return None


def _unindexed(path: Path) -> Found:
    """Read a file from its beginning to its end: one that was cut off, or has no messages for people."""
    times: list[int] = []
    faults: list[str] = []
    mode, complete = "", False
    for record in records(path, (CYCLE.topic,)):
        match record:
            case Footer():
                complete = True
            case Message():
                times.append(record.log_time)
                found = _MODE.match(record.data)
                before, mode = mode, found[1].decode() if found else ""
                if found and mode == Mode.FAULT and before != mode:
                    faults.append(str(json.loads(found[2])))
    return min(times, default=0), max(times, default=0), len(times), tuple(faults), complete


def _faults_of_lines(path: Path, lines: list[bytes]) -> tuple[str, ...]:
    """Return the reasons of faults among the messages for people."""
    found = (decode(path, LOG.topic, Log, line) for line in lines)
    return tuple(
        line.message.removeprefix(FAULT)
        for line in found
        if line.level is LogLevel.ERROR and line.message.startswith(FAULT)
    )
