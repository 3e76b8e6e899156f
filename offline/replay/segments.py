"""A log cut at its state snapshots: each piece can be run again by itself."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from tendond.daemon.control.snapshot import StateSnapshot
from tendond.daemon.recording.channels import CYCLE, STATE
from tendond.offline.logs.container import LogError
from tendond.offline.logs.run import Run
from tendond.offline.logs.ticks import tick_of
from tendond.schemas.record import CycleRecord


@dataclass
class Segment:
    """Consecutive cycles.

    Attributes:
        first: tick of the first of them.
        start: state before it, as text; none: the state in which a controller starts.
        cycles: the cycles as they are in the log.
        times: their log times [ns].
        end: state after the last of them, where the log has it.
        skip: cycles that are run again to get to the tick that was asked for, and not compared.
    """

    first: int
    start: str | None
    cycles: list[bytes] = field(default_factory=list)
    times: list[int] = field(default_factory=list)
    end: str | None = None
    skip: int = 0


@dataclass
class Gaps:
    """Gaps of a replay: ticks that are missing, and ticks after them that have no state to start from.

    Attributes:
        missing: first and last of each stretch.
        passed_over: cycles without a state before them.
        left_out: cycles that were left out of the log on purpose, while the arm was idle.
    """

    missing: list[tuple[int, int]] = field(default_factory=list)
    passed_over: int = 0
    left_out: int = 0


def segments(run: Run, gaps: Gaps, first: int = 0, last: int | None = None) -> Iterator[Segment]:
    """Yield the log between two ticks, in pieces that each begin with a state.

    Args:
        run: the log.
        gaps: written to.
        first, last: ticks to compare, both included.

    Raises:
        LogError: damaged, of another version, or not in order.
    """
    segment: Segment | None = None
    expected: int | None = None
    for topic, message in run.messages((CYCLE.topic, STATE.topic)):
        if topic == STATE.topic:
            tick, state, left_out = _snapshot(run, message.data)
            if expected is None or tick >= expected:
                if segment is not None and segment.cycles:
                    segment.end = state if tick == expected else None
                    yield from _wanted(segment, first)
                if expected is not None and left_out and tick - expected == left_out:
                    gaps.left_out += left_out
                    expected = tick
                segment = Segment(tick, state)
            continue
        tick = _tick(run, message.data)
        if last is not None and tick > last:
            break
        if expected is None and segment is None and tick == 0:
            segment = Segment(0, None)
        if expected is not None and tick != expected:
            if tick < expected:
                raise LogError(f"{run.paths[0]}: cycle {tick} comes after cycle {expected - 1}; the parts do not fit")
            gaps.missing.append((expected, tick - 1))
            if segment is not None and segment.cycles:
                yield from _wanted(segment, first)
                segment = None
        if segment is not None and segment.first + len(segment.cycles) != tick:
            segment = None
        expected = tick + 1
        if segment is None:
            gaps.passed_over += tick >= first
            continue
        segment.cycles.append(message.data)
        segment.times.append(message.log_time)
    if segment is not None and segment.cycles:
        yield from _wanted(segment, first)


def _wanted(segment: Segment, first: int) -> Iterator[Segment]:
    segment.skip = max(0, first - segment.first)
    if segment.skip < len(segment.cycles):
        yield segment


def _tick(run: Run, data: bytes) -> int:
    tick = tick_of(data)
    return run.decode(CYCLE.topic, CycleRecord, data).tick if tick is None else tick  # names what is wrong with it


def _snapshot(run: Run, data: bytes) -> tuple[int, str, int]:
    snapshot = run.decode(STATE.topic, StateSnapshot, data)
    assert isinstance(snapshot.state, str)
    return snapshot.tick, snapshot.state, snapshot.left_out
