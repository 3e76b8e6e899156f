"""What the simulator did to a run: loads and faults while it tracked, and how soon the tip recovered from each."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from tendond.offline.logs.metrics import Tracking
    from tendond.schemas.messages import SimulatorTruth


@dataclass(frozen=True)
class Injection:
    """A load or a fault of the simulator.

    Attributes:
        what: its name, such as "impact".
        start: first cycle in which it acted. end: first one after it; none: it acted to the end of the log.
    """

    what: str
    start: int
    end: int | None


@dataclass(frozen=True)
class Recovery:
    """How a run recovered from one injection.

    Attributes:
        what: name of the injection; with " ends" behind it, for the end of one that lasted.
        time_s: its time since the start of tracking [s].
        recovery_s: time from then on until the tip stays within 5 % of the target [s], up to the next injection; 0 if
            it never left; none if it did not come back.
        deviation_mm: largest distance of the tip from its reference until the next injection [mm].
    """

    what: str
    time_s: float
    recovery_s: float | None
    deviation_mm: float


def injections(ticks: Iterable[int], truth: Iterable["SimulatorTruth"]) -> list[Injection]:
    """List what the simulator injected, in order.

    Args:
        ticks: cycle beside which each of `truth` was recorded.
        truth: the simulator's.
    """
    open_at: dict[str, int] = {}
    found: list[Injection] = []
    for tick, one in zip(ticks, truth, strict=True):
        for what in set(open_at) - set(one.injected):
            found.append(Injection(what, open_at.pop(what), tick))
        for what in one.injected:
            open_at.setdefault(what, tick)
    found += [Injection(what, start, None) for what, start in open_at.items()]
    return sorted(found, key=lambda one: (one.start, one.what))


def within(found: Iterable[Injection], first: int, last: int) -> tuple[Injection, ...]:
    """Select those that begin after cycle `first` and up to `last`; their cycles are counted from `first` on."""
    return tuple(
        replace(one, start=one.start - first, end=None if one.end is None or one.end > last else one.end - first)
        for one in found
        if first < one.start <= last
    )


def recoveries(run: "Tracking", band: float, settled_at: int | None) -> list[Recovery]:
    """Measure the recovery from each injection of a run, in order.

    The end of an injection counts as another one where it lasted longer than the run took to settle: a weight that is
    taken off again, but not an impact.

    Args:
        run: the run.
        band: half-width of the band, as a fraction of the step.
        settled_at: first settled iteration before the injections; none: the run had not settled.
    """
    moments = _moments(run.injections, settled_at)
    outside = np.abs(run.tip[:, run.axis] - run.target[run.axis]) > band * abs(run.step)
    apart = 1000.0 * np.linalg.norm(run.tip - run.reference, axis=1)
    ends = [*(start for start, _ in moments), len(run.tip)][1:]
    found = []
    for (start, what), end in zip(moments, ends, strict=True):
        late = np.flatnonzero(outside[start:end])
        back = start + int(late[-1]) + 1 if late.size else start
        recovery = None if late.size and back == end else float(run.time[back] - run.time[start])
        found.append(Recovery(what, float(run.time[start]), recovery, float(apart[start:end].max())))
    return found


def _moments(found: Sequence[Injection], settled_at: int | None) -> list[tuple[int, str]]:
    """List iteration and name of each beginning, and of each end that counts; one an iteration."""
    moments: dict[int, str] = {}
    for one in found:
        moments[one.start] = f"{moments[one.start]}, {one.what}" if one.start in moments else one.what
    for one in found:
        if one.end is not None and settled_at is not None and one.end - one.start > settled_at:
            moments.setdefault(one.end, f"{one.what} ends")
    return sorted(moments.items())
