"""Report of a campaign, in Markdown."""

from collections.abc import Iterable, Sequence
from typing import Any

from tendond.offline.robustness.points import FEEDBACKS
from tendond.offline.robustness.run import Rows
from tendond.offline.robustness.summary import GOAL, MEASURES, Groups, alarms, counts, groups, misses, removed, worst

UNITS = {
    "settling_iterations": ("settling", "iterations"),
    "impact_settling_iterations": ("settling after an impact", "iterations"),
    "ripple_mm": ("ripple", "mm"),
    "overshoot_percent": ("overshoot of x", "%"),
    "path_overshoot_percent": ("overshoot along the curve", "%"),
    "tpl_mm": ("total path length of x", "mm"),
    "rise_iterations": ("rise", "iterations"),
    "steady_error_mm": ("steady error", "mm"),
    "open_loop_error_mm": ("steady error in open loop", "mm"),
    "peak_tension_n": ("largest tension", "N"),
    "force_error_n": ("error of the estimated force", "N"),
}

MISSES = {
    "fault": "fault",
    "settles": "slow to settle",
    "smooth": "ripple",
    "bounded": "tension out of bounds",
    "recovers": "slow after the impact",
}

SHOWN = 30
"""Maximum number of groups of points that miss the goal."""


def report(rows: Rows, settings: dict[str, Any]) -> str:
    """Write the page: how many points meet the goal, one axis at a time for every feedback, the worst, and what "
    "misses."""
    known, misconfigured = groups(rows), groups(rows, misconfigured=True)
    parts = [
        "# Robustness",
        f"{len(rows)} runs of the closed loop in lockstep with a simulated plant; set `{settings['points']}`, seed "
        f"{settings['seed']}, tendond {settings['version']}, source {settings['source']}.",
        f"Goal of a point: {GOAL}. Measured on the simulator's tip, not on the noisy pose. Cost of a rate "
        "limit: the cycles before settling in which the command was at it, bounded by those of the tendon's whole "
        "travel.",
        "The delay of the poses and the lag of the actuators are configured (poses carry capture times, and "
        "the lag is identified); points with a wrong configuration are listed separately.",
        "## Points that meet the goal",
        _counts(known),
        "A fault is a false alarm if the same run with these faults switched off comes to rest at its "
        "reference within six seconds, and a true one if it keeps oscillating, or does not reach it.",
    ]
    axes = {key: [row for row in part if row[0].part == "axes"] for key, part in known.items()}
    if any(axes.values()):
        parts += [
            "## One axis at a time",
            "Settling [iterations] / ripple [mm]; for impacts, settling after the impact. **Bold**: misses the goal.",
            *(_axes_table(law, axes) for law in dict.fromkeys(law for law, _ in axes)),
        ]
    parts += _removed(known)
    parts.append("## Worst of each measure")
    parts += [_worst(law, feedback, part) for (law, feedback), part in known.items()]
    if misconfigured:
        parts += ["## Delay or lag configured wrongly", "Delay wrong by one cycle, lag by 0.1.", _counts(misconfigured)]
        parts += [_misconfigured(misconfigured)]
    parts.append("## Points that miss the goal")
    parts += [_missed(law, feedback, part) for (law, feedback), part in known.items()]
    return "\n\n".join(parts) + "\n"


def _markdown(head: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ["---"] * len(head), *lines))


def _counts(parts: dict[tuple[str, str], Rows]) -> str:
    head = ("law", "feedback", "points", "meet the goal", *MISSES.values(), "true alarms", "false alarms")
    lines = [
        (_words(law), name, *map(str, counts(rows).values()), *map(str, alarms(rows).values()))
        for (law, name), rows in parts.items()
    ]
    return _markdown(head, lines)


def _removed(parts: Groups) -> list[str]:
    """Write the errors with and without feedback, if the open loop was run."""
    lines = [
        (
            _words(law),
            feedback,
            str(found["points"]),
            *(f"{found[loop][key]:.3g}" for loop in ("open_loop", "closed_loop") for key in ("median", "p95", "worst")),
            found["open_loop"]["at"],
        )
        for (law, feedback), rows in parts.items()
        if (found := removed(rows)) is not None
    ]
    if not lines:
        return []
    return [
        "## What the feedback removes",
        "Steady error of the tip [mm] at the end of tracking, before any impact. Open loop: the plant under the tendon "
        "commands of the nominal run, without feedback. Points that end in a fault are left out.",
        _markdown(
            ("law", "feedback", "points", *(f"{loop}: {key}" for loop in ("open loop", "closed loop") for key in
             ("median", "95 %", "worst")), "worst open loop at"), lines,
        ),
    ]  # fmt: skip


def _axes_table(law: str, parts: dict[tuple[str, str], Rows]) -> str:
    """Write a table with a line for each plant and a column for each feedback."""
    columns = {feedback: parts[law, feedback] for feedback in FEEDBACKS if parts.get((law, feedback))}
    cells: dict[str, dict[str, str]] = {}
    for feedback, rows in columns.items():
        for point, result in rows:
            settling = result.impact_settling_iterations if point.impact_n else result.settling_iterations
            ripple = "" if point.impact_n or result.ripple_mm is None else f" / {result.ripple_mm:.2g}"
            text = f"{'never' if settling is None else settling}{ripple}"
            if result.mode != "tracking":
                text += f" ({result.reason})"
            cells.setdefault(str(point), {})[feedback] = text if result.meets else f"**{text}**"
    lines = [(name, *(found.get(feedback, "") for feedback in columns)) for name, found in cells.items()]
    return f"### {_words(law)}\n\n" + _markdown(("plant", *columns), lines)


def _worst(law: str, feedback: str, rows: Rows) -> str:
    lines = []
    for measure in MEASURES:
        row = worst(rows, measure)
        if row is not None:
            name, unit = UNITS[measure]
            value = getattr(row[1], measure)
            lines.append((name, "never" if value is None else f"{value:.3g} {unit}", str(row[0])))
    return f"### {_words(law)}, {feedback}\n\n" + _markdown(("measure", "worst", "at"), lines)


def _misconfigured(parts: dict[tuple[str, str], Rows]) -> str:
    lines = [
        (
            _words(law),
            feedback,
            str(point),
            str(result.settling_iterations or "never"),
            f"{result.ripple_mm or 0.0:.2g}",
        )
        for (law, feedback), rows in parts.items()
        for point, result in rows
        if not result.meets
    ]
    if not lines:
        return "All of them meet the goal."
    return "These miss it:\n\n" + _markdown(("law", "feedback", "plant", "settling", "ripple mm"), lines)


def _missed(law: str, feedback: str, rows: Rows) -> str:
    """Group the points that miss the goal by what they miss and where: drive, delay, lag, load."""
    found: dict[tuple[str, str], Rows] = {}
    for point, result in rows:
        if not result.meets:
            how = ", ".join(MISSES[name] for name in misses(result))
            where = (
                f"{'servos' if point.drive == 'displacement' else 'ideal tension'}, delay {point.delay_cycles}, "
                f"lag {point.lag_factor:g}, load {point.load_g:g} g"
                if point.part in ("corners", "grid")
                else "random points"
                if point.part == "sample"
                else str(point)
            )
            found.setdefault((where, how), []).append((point, result))
    title = f"### {_words(law)}, {feedback}\n\n"
    if not found:
        return title + "None."
    order = sorted(found.items(), key=lambda item: -len(item[1]))
    lines = [(where, how, str(len(part)), _extent(part)) for (where, how), part in order[:SHOWN]]
    rest = f"\n\nAnd {sum(len(part) for _, part in order[SHOWN:])} more points." if len(order) > SHOWN else ""
    return title + _markdown(("plant", "misses", "points", "settling; ripple mm; after the impact"), lines) + rest


def _extent(rows: Rows) -> str:
    """Ranges of the measures in the goal; settling without the cost of the rate limit."""
    results = [result for _, result in rows]
    settling = [
        None if one.settling_iterations is None else one.settling_iterations - one.rate_cost_iterations
        for one in results
    ]
    ripple = [one.ripple_mm for one in results if one.ripple_mm is not None]
    after = [one.impact_settling_iterations for point, one in rows if point.impact_n]
    smooth = _range(f"{min(ripple):.2g}", f"{max(ripple):.2g}") if ripple else "-"
    return f"{_span(settling)}; {smooth}; {_span(after) if after else '-'}"


def _span(values: list[int | None]) -> str:
    known = [value for value in values if value is not None]
    never = len(values) - len(known)
    parts = [_range(str(min(known)), str(max(known)))] if known else []
    return ", ".join(parts + ([f"never {never}"] if never else []))


def _range(minimum: str, maximum: str) -> str:
    return minimum if minimum == maximum else f"{minimum} to {maximum}"


def _words(law: str) -> str:
    return law.replace("_", " ")
