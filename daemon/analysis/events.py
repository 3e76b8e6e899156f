"""What happened in a run beside control: requests, changes of mode, faults, inputs that were not used, limits."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord

REQUEST, MODE, FAULT = "request", "mode", "fault"
REJECTED, NO_POSE, LIMIT = "input rejected", "no new pose", "limit met"
NO_SOLUTION, MISSED = "no solution", "deadline missed"
KINDS = (REQUEST, MODE, FAULT, REJECTED, NO_POSE, LIMIT, NO_SOLUTION, MISSED)


@dataclass(frozen=True)
class Event:
    """One thing in one cycle.

    Attributes:
        tick: of the cycle. time: nominal, since the first cycle of the run [s].
        kind: one of `KINDS`.
        text: what, in a few words.
    """

    tick: int
    time: float
    kind: str
    text: str


def events(records: Sequence[CycleRecord]) -> list[Event]:
    """Of a run, in order."""
    found = []
    mode: Mode | None = None
    for record in records:

        def add(kind: str, text: str, record: CycleRecord = record) -> None:
            found.append(Event(record.tick, record.time, kind, text))

        if record.inputs.request is not None:
            add(REQUEST, f"{record.inputs.request.value}: {record.reply}")
        if record.mode is not mode:
            add(FAULT if record.mode is Mode.FAULT else MODE, f"{record.mode.value}: {record.reason}")
            mode = record.mode
        for reason, count in Counter(record.rejected).items():
            add(REJECTED, reason if count == 1 else f"{count} {reason}")
        if record.inputs.pose is None and record.pose_age is not None:
            add(NO_POSE, f"the newest is {record.pose_age} cycles old")
        for name in record.limited:
            add(LIMIT, name)
        if record.model.error:
            add(NO_SOLUTION, record.model.error)
        if record.inputs.missed_ticks:
            add(MISSED, f"{record.inputs.missed_ticks} before this cycle")
    return found


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
