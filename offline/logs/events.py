"""Events of a run: requests, changes of mode, faults, rejected inputs, limits."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

REQUEST, MODE, FAULT = "request", "mode", "fault"
REJECTED, NO_POSE, LIMIT = "input rejected", "no new pose", "limit met"
NO_SOLUTION, MISSED, SAFETY = "no solution", "deadline missed", "safety filter"
KINDS = (REQUEST, MODE, FAULT, REJECTED, NO_POSE, LIMIT, SAFETY, NO_SOLUTION, MISSED)


@dataclass(frozen=True)
class Event:
    """One thing in one cycle.

    Attributes:
        tick: the cycle's tick. time: nominal time since the first cycle of the run [s].
        kind: one of `KINDS`.
        text: description in a few words.
    """

    tick: int
    time: float
    kind: str
    text: str


def events(records: Sequence[CycleRecord]) -> list[Event]:
    """List the events of a run, in order."""
    found = []
    mode: Mode | None = None
    jogged = ""
    for record in records:

        def add(kind: str, text: str, record: CycleRecord = record) -> None:
            found.append(Event(record.tick, record.time, kind, text))

        if record.inputs.request not in (None, ControlAction.STATUS):  # to ask is not to request
            assert record.inputs.request is not None
            text = f"{record.inputs.request.value}: {record.reply}"
            if record.inputs.request is not ControlAction.JOG or text != jogged:  # these are streamed
                add(REQUEST, text)
            jogged = text if record.inputs.request is ControlAction.JOG else ""
        if record.mode is not mode:
            add(FAULT if record.mode is Mode.FAULT else MODE, f"{record.mode.value}: {record.reason}")
            mode = record.mode
        for reason, count in Counter(record.rejected).items():
            add(REJECTED, reason if count == 1 else f"{count} {reason}")
        if record.inputs.pose is None and record.pose_age is not None:
            add(NO_POSE, f"the newest is {record.pose_age} cycles old")
        for name in record.limited:
            add(LIMIT, name)
        if record.safety is not None:
            add(SAFETY, record.safety.constraint)
        if record.model.error:
            add(NO_SOLUTION, record.model.error)
        if record.inputs.missed_ticks:
            add(MISSED, f"{record.inputs.missed_ticks} before this cycle")
    return found


@dataclass(frozen=True)
class Tally:
    """All events of one kind and text.

    Attributes:
        kind, text: those of the event; of the first one, where the texts contain numbers.
        cycles: cycles in which it happened. stretches: runs of such cycles. longest: longest run [cycles].
        first, last: the first and the last event.
    """

    kind: str
    text: str
    cycles: int
    stretches: int
    longest: int
    first: Event
    last: Event


def tallies(found: Sequence[Event]) -> list[Tally]:
    """Count the events of each kind, in the order of their first occurrence; without requests, modes and faults."""
    groups: dict[tuple[str, str], list[Event]] = {}
    for event in found:
        if event.kind not in (REQUEST, MODE, FAULT):
            groups.setdefault((event.kind, event.text if event.kind in (REJECTED, LIMIT, SAFETY) else ""), []).append(
                event
            )
    result = []
    for (kind, _), group in groups.items():
        lengths = [1]
        for before, after in pairwise(group):
            if after.tick == before.tick + 1:
                lengths[-1] += 1
            else:
                lengths.append(1)
        text = "" if kind == NO_POSE else group[0].text
        result.append(Tally(kind, text, len(group), len(lengths), max(lengths), group[0], group[-1]))
    return result


def mode_spans(records: Sequence[CycleRecord]) -> list[tuple[float, float, Mode]]:
    """Start and end of each stretch in one mode [s]."""
    spans: list[tuple[float, float, Mode]] = []
    for record, after in zip(records, [*records[1:], None], strict=True):
        end = record.time if after is None else after.time
        if spans and spans[-1][2] is record.mode:
            spans[-1] = (spans[-1][0], end, record.mode)
        else:
            spans.append((record.time, end, record.mode))
    return spans
