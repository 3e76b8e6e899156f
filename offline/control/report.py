"""The table of the comparison."""

from collections.abc import Iterable

from tendond.offline.control.cases import Case
from tendond.offline.control.run import Outcome

HEADING = (
    "| robot | law | task | plant | observer | Hz | RMS mm | worst mm | end mm | settled s | ripple N | at limits | "
    "cycle ms | p99 ms | p99 in steps | fault |\n|" + 16 * " --- |"
)

MATCHED_MM, UNLIKE_MM, COST_MS = 0.2, 1.5, 4.0
"""Goals of the best law: RMS on the model itself, and on the plant unlike it [mm]; 99th percentile of a cycle [ms]."""


def row(case: Case, one: Outcome) -> str:
    """Return the row of a case."""
    settled = "-" if one.settling_s is None else f"{one.settling_s:.2f}"
    return (
        f"| {case.robot} | {case.law} | {case.task} | {case.plant} | {case.observer} | {1.0 / case.period:.0f} | "
        f"{one.rms_mm:.2f} | {one.worst_mm:.2f} | {one.end_mm:.2f} | {settled} | {one.ripple_n:.3f} | "
        f"{one.violations} | {one.cycle_ms:.1f} | {one.slow_ms:.1f} | {one.steps:.0f} | {one.fault} |"
    )


def misses(done: Iterable[tuple[Case, Outcome]]) -> list[str]:
    """Return the goals that no law meets, by task and plant, of tasks in space; and those of cost."""
    best: dict[tuple[str, str, str], float] = {}
    found = []
    for case, one in done:
        if case.law == "mpc" and case.period >= 0.01 and one.slow_ms > COST_MS:
            found.append(f"{case.robot}, {case.task}, {case.plant}: {one.slow_ms:.1f} ms, goal {COST_MS:g} ms")
        if case.plant in ("matched", "unlike") and "step" not in case.task and "paper" not in case.task:
            key = (case.robot, case.task, case.plant)
            best[key] = min(best.get(key, float("inf")), one.rms_mm if not one.fault else float("inf"))
    for (robot, task, plant), rms in best.items():
        goal = MATCHED_MM if plant == "matched" else UNLIKE_MM
        if not rms <= goal:
            found.append(f"{robot}, {task}, {plant}: best RMS {rms:.2f} mm, goal {goal:g} mm")
    return found
