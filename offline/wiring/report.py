"""The study's outcomes as rows of a table, one per kind of mistake: as text, JSON and Markdown."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from tendond.offline.wiring.study import MOVED, PROBED, PULLED, RIGHT, WiringOutcome


@dataclass(frozen=True)
class WiringRow:
    """The runs of a kind of mistake in a chain.

    Attributes:
        chain, group: the set of runs. runs: their number.
        refused: before anything was pulled. faulted: later. missed: neither, or too late; of right rigs: alarms.
        seconds: time to the latest fault. moved, pulled: the worst of all; see `WiringOutcome`.
        worst: the run that fell short, and what was said of it; empty where none did.
    """

    chain: str
    group: str
    runs: int
    refused: int
    faulted: int
    missed: int
    seconds: float
    moved: float
    pulled: float
    worst: str

    @property
    def holds(self) -> bool:
        """True if every wrong rig was noticed in time, and no correct one."""
        return self.missed == 0


def rows(outcomes: Iterable[WiringOutcome]) -> list[WiringRow]:
    """Gather outcomes into rows, in their order."""
    groups: dict[tuple[str, str], list[WiringOutcome]] = {}
    for outcome in outcomes:
        groups.setdefault((outcome.chain, outcome.group), []).append(outcome)
    return [_row(chain, group, found) for (chain, group), found in groups.items()]


def _row(chain: str, group: str, found: Sequence[WiringOutcome]) -> WiringRow:
    right = group == RIGHT
    missed = [one for one in found if (one.noticed if right else not one.in_time)]
    refused = [one for one in found if one.noticed and one.seconds == 0.0]
    worst = max(missed, key=lambda one: one.moved, default=None)
    return WiringRow(
        chain=chain,
        group=group,
        runs=len(found),
        refused=len(refused),
        faulted=sum(one.noticed for one in found) - len(refused),
        missed=len(missed),
        seconds=max(one.seconds for one in found),
        moved=max(one.moved for one in found),
        pulled=max(one.pulled for one in found),
        worst="" if worst is None else f"{worst.law}, {worst.name}: {worst.by}",
    )


def markdown(table: Sequence[WiringRow]) -> str:
    """Write the table for the documents."""
    lines = [
        f"The tip of a wrong rig may move by {100 * (MOVED + PROBED):g} % of the length, including the probe's 3 %, "
        f"and its tendons may pull {100 * PULLED:g} % of `limits.tension_max`;\n"
        "for correctly wired rigs every refusal and fault is a false alarm.",
        "",
        "| chain | what is wrong | runs | refused | fault | too late or missed | latest [s] | tip moved | pulled |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for row in table:
        right = row.group == RIGHT
        moved, pulled = ("", "") if right else (f"{100 * row.moved:.1f} %", f"{100 * row.pulled:.1f} %")
        cells = (row.chain, "nothing" if right else row.group, row.runs, row.refused, row.faulted, row.missed,
                 f"{row.seconds:.1f}", moved, pulled)  # fmt: skip
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return "\n".join(lines) + "\n"
