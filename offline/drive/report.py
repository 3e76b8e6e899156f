"""Table of the study of the drive, and its goals."""

from collections.abc import Sequence

from tendond.offline.drive.cases import Case
from tendond.offline.drive.measure import DriveOutcome
from tendond.schemas.messages import Mode

RMS_MM, WORST_MM, CHATTER_N, LIMITED, SWING_MM = 2.0, 5.0, 0.1, 0.01, 0.5
"""Goals of a chain of which all is configured, on the circle of 250 mm in 4 s: error of the tip, chatter of the
commanded and the true tensions at rest, cycles at a limit, swing of the tip at rest: limit cycles have millimetres."""

HEADING = (
    "| chain | RMS [mm] | worst [mm] | late [ms] | change [N/cycle] | chatter, commanded [N] | chatter, true [N]"
    " | swing [mm] | at a limit |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


def meets(outcome: DriveOutcome) -> bool:
    """Return whether a chain meets the goals; one that could not be measured does not."""
    return (
        outcome.mode == Mode.TRACKING.value
        and outcome.rms_mm <= RMS_MM
        and outcome.worst_mm <= WORST_MM
        and max(outcome.chatter_command_n, outcome.chatter_n) <= CHATTER_N
        and outcome.limited <= LIMITED
        and outcome.swing_mm <= SWING_MM
    )


def markdown(rows: Sequence[tuple[Case, DriveOutcome]]) -> str:
    """Write the table, a line for each chain."""
    return "\n".join([HEADING, *(_row(case, outcome) for case, outcome in rows)])


def _row(case: Case, one: DriveOutcome) -> str:
    if one.mode != Mode.TRACKING.value:
        return f"| {case.name} | {one.mode}: {one.reason} | | | | | | | |"
    cells = (
        f"{one.rms_mm:.2f}",
        f"{one.worst_mm:.2f}",
        f"{one.late_ms:.1f}",
        f"{one.change_n:.2f}",
        f"{one.chatter_command_n:.3f}",
        f"{one.chatter_n:.3f}",
        f"{one.swing_mm:.2f}",
        f"{one.limited:.1%}",
    )
    return f"| {case.name} | {' | '.join(cells)} |"
