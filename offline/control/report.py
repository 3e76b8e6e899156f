"""The table of the comparison."""

from collections.abc import Iterable

from tendond.offline.control.cases import SECTIONS, Case
from tendond.offline.control.run import Outcome

HEADING = (
    "| robot | law | task | plant | observer | Hz | RMS mm | worst mm | end mm | RMS deg | settled s | ripple N | "
    "at limits | cycle ms | p99 ms | p99 in steps | fault |\n|" + 17 * " --- |"
)

MATCHED_MM, UNLIKE_MM, COST_MS = 0.2, 1.5, 4.0
"""Goals of the best law: RMS on the model itself, and on the plant unlike it [mm]; 99th percentile of a cycle [ms]."""

SECTIONS_MM, SECTIONS_DEGREES = 3.0, 2.0
"""Goals of the best law for robots of sections on the model itself: RMS [mm], and of the direction [degrees]."""


def row(case: Case, one: Outcome) -> str:
    """Return the row of a case."""
    turned = "-" if one.rms_degrees is None else f"{one.rms_degrees:.2f}"
    settled = "-" if one.settling_s is None else f"{one.settling_s:.2f}"
    return (
        f"| {case.robot} | {case.law} | {case.task} | {case.plant} | {case.observer} | {1.0 / case.period:.0f} | "
        f"{one.rms_mm:.2f} | {one.worst_mm:.2f} | {one.end_mm:.2f} | {turned} | {settled} | {one.ripple_n:.3f} | "
        f"{one.violations} | {one.cycle_ms:.1f} | {one.slow_ms:.1f} | {one.steps:.0f} | {one.fault} |"
    )


def misses(done: Iterable[tuple[Case, Outcome]]) -> list[str]:
    """Return the goals that no law meets, by task and plant, of tasks in space; and those of cost."""
    best: dict[tuple[str, str, str], list[Outcome]] = {}
    found = []
    for case, one in done:
        if case.law == "mpc" and case.period >= 0.01 and one.slow_ms > COST_MS:
            found.append(f"{case.robot}, {case.task}, {case.plant}: {one.slow_ms:.1f} ms, goal {COST_MS:g} ms")
        tracks = case.plant in ("matched", "unlike") and "step" not in case.task and "paper" not in case.task
        if tracks and (case.robot not in SECTIONS or case.plant == "matched"):
            best.setdefault((case.robot, case.task, case.plant), []).append(one)
    for (robot, task, plant), some in best.items():
        name, ended = f"{robot}, {task}, {plant}", [one for one in some if not one.fault]
        rms = min((one.rms_mm for one in ended), default=float("inf"))
        goal = SECTIONS_MM if robot in SECTIONS else MATCHED_MM if plant == "matched" else UNLIKE_MM
        if not rms <= goal:
            found.append(f"{name}: best RMS {rms:.2f} mm, goal {goal:g} mm")
        turned = min((one.rms_degrees for one in ended if one.rms_degrees is not None), default=0.0)
        if robot in SECTIONS and not turned <= SECTIONS_DEGREES:
            found.append(f"{name}: best RMS {turned:.2f} degrees, goal {SECTIONS_DEGREES:g} degrees")
    return found
