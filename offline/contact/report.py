"""What the study of contacts found: rows, targets, tables and files."""

import csv
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from tendond.offline.contact.cases import Case
from tendond.offline.contact.run import BASE, LATER, Outcome
from tendond.offline.files import whole, write_whole

FOUND_TIME, FOUND_SHARE = 0.1, 0.9
"""Time within which a contact is to be found [s], and part of them that are."""

PLACE, FORCE = 0.05, 0.2
"""Medians of the errors of place, as a part of the length, and of force."""

ALARMS_PER_HOUR = 1.0
"""False alarms of an arm that nothing touches."""

PARTS = ((BASE, 0.5), (0.5, 0.75), (0.75, 1.0))
"""Parts of the body whose contacts are counted apart, in the length."""

GOAL_FORCE, GOAL_PLACE = 0.2, 0.5
"""Contacts that the targets are for: forces on the paper's robot from this one on [N], places from there to the tip."""


@dataclass(frozen=True)
class ContactRow:
    """Contacts of one case with one part of the body.

    Attributes:
        case: in words. first, last: part of the body, in its length. runs: number of them.
        found: part found while they lasted; in_time: within `FOUND_TIME`. delay: median time [s].
        place, force, size: medians of the absolute errors at the last of `LATER`; early_place: of place at the first.
        covered: part whose interval has the place. width: median of the interval.
        released: part of those found whose end was seen; release: median time [s].
        tip: median of the RMS errors of the tip from the onset on [m].
        goal: whether the targets are for it. meets: whether it meets them.
    """

    case: str
    first: float
    last: float
    runs: int
    found: float
    in_time: float
    delay: float
    early_place: float
    place: float
    force: float
    size: float
    covered: float
    width: float
    released: float
    release: float
    tip: float
    goal: bool
    meets: bool


@dataclass(frozen=True)
class FreeRow:
    """Free motion of one case; `hours`: of it. `alarms`: contacts that were found in it."""

    case: str
    hours: float
    alarms: int

    @property
    def meets(self) -> bool:
        """True if there are no more alarms than may be; of less than an hour, than in one."""
        return self.alarms <= ALARMS_PER_HOUR * max(self.hours, 1.0)


def contact_rows(outcomes: Sequence[Outcome]) -> list[ContactRow]:
    """Return the rows of the runs with a contact."""
    rows = []
    for case in dict.fromkeys(one.case for one in outcomes if one.case.force):
        for first, last in PARTS:
            some = [one for one in outcomes if one.case == case and first <= one.place < last]
            if some:
                rows.append(_row(case, first, last, some))
    return rows


def _row(case: Case, first: float, last: float, some: Sequence[Outcome]) -> ContactRow:
    delays = np.array([one.found for one in some])
    late = [one.samples[-1] for one in some if one.samples[-1] is not None]
    early = [abs(one.samples[0].place) for one in some if one.samples[0] is not None]
    seen = [one.released for one in some if np.isfinite(one.found)]
    found, in_time = float(np.mean(np.isfinite(delays))), float(np.mean(delays <= FOUND_TIME))
    place, force = _median([abs(one.place) for one in late]), _median([one.force for one in late])
    return ContactRow(
        case=case.name, first=first, last=last, runs=len(some), found=found, in_time=in_time, delay=_median(delays),
        early_place=_median(early), place=place, force=force, size=_median([abs(one.size) for one in late]),
        covered=float(np.mean([one.covered for one in late])) if late else np.nan,
        width=_median([one.width for one in late]),
        released=float(np.mean(np.isfinite(seen))) if seen else np.nan, release=_median(seen),
        tip=_median([one.tip for one in some]), goal=case.force >= GOAL_FORCE and first >= GOAL_PLACE,
        meets=in_time >= FOUND_SHARE and place <= PLACE and force <= FORCE,
    )  # fmt: skip


def _median(values: Sequence[float] | np.ndarray) -> float:
    """Median of the numbers among them; nan where there are none."""
    numbers = np.asarray(values, dtype=np.float64)
    numbers = numbers[np.isfinite(numbers)]
    return float(np.median(numbers)) if len(numbers) else float("nan")


def free_rows(outcomes: Sequence[Outcome]) -> list[FreeRow]:
    """Return the rows of what is free motion: runs without a contact, and those with one before its onset."""
    free: dict[tuple[str, bool], list[Outcome]] = {}
    for one in outcomes:
        free.setdefault((one.case.robot, one.case.moving), []).append(one)
    return [
        FreeRow(
            f"{robot}, {'moving' if moving else 'resting'}",
            sum(o.free for o in some) / 3600.0,
            sum(o.alarms for o in some),
        )
        for (robot, moving), some in free.items()
    ]


def meets(rows: Sequence[ContactRow], free: Sequence[FreeRow]) -> bool:
    """Return whether all targets are met."""
    return all(row.meets for row in rows if row.goal) and all(row.meets for row in free)


HEADS = (
    "contact", "place", "runs", "found", "in 0.1 s", "median", "place, 0.1 s", "place, 0.4 s", "force", "its size",
    "in interval", "interval", "end seen", "after", "tip",
)  # fmt: skip


def cells(row: ContactRow) -> tuple[str, ...]:
    """Return a row's cells; places in percent of the length, forces in percent of the force."""
    return (
        row.case, f"{row.first:g} to {row.last:g} L", str(row.runs), _percent(row.found), _percent(row.in_time),
        f"{1e3 * row.delay:.0f} ms", _percent(row.early_place, 1), _percent(row.place, 1), _percent(row.force),
        _percent(row.size), _percent(row.covered), _percent(row.width), _percent(row.released),
        f"{1e3 * row.release:.0f} ms", f"{1e3 * row.tip:.2f} mm",
    )  # fmt: skip


def _percent(value: float, digits: int = 0) -> str:
    return f"{100.0 * value:.{digits}f} %" if np.isfinite(value) else ""


def markdown(rows: Sequence[ContactRow], free: Sequence[FreeRow]) -> str:
    """Return the tables."""
    lines = ["| " + " | ".join(HEADS) + " |", "| " + " | ".join("---" for _ in HEADS) + " |"]
    lines += ["| " + " | ".join(cells(row)) + " |" for row in rows]
    lines += ["", "| free motion | hours | false alarms |", "| --- | --- | --- |"]
    lines += [f"| {row.case} | {row.hours:.2f} | {row.alarms} |" for row in free]
    missed = [f"{row.case}, {row.first:g} to {row.last:g} L" for row in rows if row.goal and not row.meets]
    missed += [f"{row.case}: false alarms" for row in free if not row.meets]
    lines += ["", "All targets are met." if not missed else f"Targets missed: {'; '.join(missed)}."]
    return "\n".join(lines) + "\n"


def write(outcomes: Sequence[Outcome], rows: Sequence[ContactRow], free: Sequence[FreeRow], out: Path) -> None:
    """Write results.csv, a line a run, summary.json and report.md.

    Raises:
        OSError: a file cannot be written.
    """
    with whole(out / "results.csv") as draft, draft.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        moments = [f"{name}_{later}" for later in LATER for name in ("place", "force", "covered")]
        writer.writerow(("case", "seed", "place", "found_s", *moments, "released_s", "alarms", "free_s", "tip_m"))
        for one in outcomes:
            values = [
                value for s in one.samples for value in (("", "", "") if s is None else (s.place, s.force, s.covered))
            ]
            ends = one.released, one.alarms, one.free, one.tip
            writer.writerow((one.case.name, one.seed, one.place, one.found, *values, *ends))
    summary = {"contacts": [asdict(row) for row in rows], "free": [asdict(row) for row in free]}
    write_whole(out / "summary.json", json.dumps(summary, indent=2) + "\n")
    write_whole(out / "report.md", "# Contacts anywhere along the body\n\n" + markdown(rows, free))
