"""Health of the controller in the live view: rows with a label."""

from rich.text import Text

from tendond.schemas.messages import Status

LABEL = 10
DIM, GOOD, BAD, WARN = "dim", "green", "bold red", "yellow"


def labelled(label: str, value: Text) -> Text:
    """Return a row of the frame, with its label."""
    return Text.assemble((f" {label:<{LABEL - 1}}", DIM), value)


def folded(row: Text, width: int) -> list[Text]:
    """Divide a row that is wider at spaces, and indent what is below like a value; colours are kept."""
    rows: list[Text] = []
    while row.cell_len > width > LABEL + 8:
        place = row.plain.rfind(" ", LABEL + 1, width + 1)
        if place < 0:
            break
        first, row = row.divide([place])
        first.rstrip()
        rows.append(first)
        row = Text.assemble(" " * LABEL, row[1:])
    return [*rows, row]


def health_rows(status: Status) -> list[Text]:
    """Write loop, filter, sensors, what was rejected, and the log."""
    loop = status.loop
    rejected = ", ".join(f"{count} {reason}" for reason, count in sorted(status.rejected.items(), key=_descending))
    days = "" if loop.log_days_left is None else f", space for {loop.log_days_left:.1f} days"
    log = loop.log_error or f"{loop.log_dropped} entries dropped{days}"
    return [
        labelled("cycle", Text(f"{loop.cycle_ms_median:.2f} ms, p99 {loop.cycle_ms_p99:.2f} ms")),
        labelled("phase", Text(loop.phase_in_words)),
        labelled("cycles", Text(f"{loop.cycles}, {loop.missed_ticks} missed", style=WARN if loop.missed_ticks else "")),
        *_filter(status),
        *([labelled("sensors", _sensor_text(status))] if status.sensors else []),
        labelled("rejected", Text(rejected or "nothing", style=WARN if rejected else "")),
        *([labelled("safety", Text(status.safety, style=BAD))] if status.safety else []),
        *([labelled("refused", Text(status.refused, style=BAD))] if status.refused else []),
        labelled("log", Text(log, style=BAD if loop.log_error else WARN if loop.log_dropped else "")),
        *(labelled("tuned", Text(text, style=WARN)) for text in tuned_in_words(status)),
    ]


def _filter(status: Status) -> list[Text]:
    found = status.filter
    if found is None:
        return []
    force = Text(found.force_in_words, style=WARN if found.is_inconsistent else "")
    rows = [labelled("force", force), labelled("tip 95 %", Text(found.tip_in_words))]
    if found.contact is not None:
        rows.append(labelled("contact", Text(found.contact.in_words, style=WARN)))
    return rows


def sensors_in_words(status: Status) -> list[str]:
    """Return rate or silence of each sensor."""
    return [f"{name} {health.in_words}" for name, health in status.sensors.items()]


def tuned_in_words(status: Status) -> list[str]:
    """Return each tuned key, without the table of all laws, and its value."""
    return [f"{key.removeprefix('control.laws.')} = {one.in_words}" for key, one in status.tuned.items()]


def _sensor_text(status: Status) -> Text:
    bad = any(health.silent or health.objection for health in status.sensors.values())
    return Text("; ".join(sensors_in_words(status)), style=WARN if bad else "")


def _descending(item: tuple[str, int]) -> int:
    return -item[1]
