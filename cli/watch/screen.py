"""A frame of the live view, as text of a given size; and a line of it, for where there is no screen."""

import math
import textwrap
from collections.abc import Sequence

from rich.text import Text

from tendond.cli.watch.bus_snapshot import SILENT_SECONDS, Seen, Stream
from tendond.cli.watch.canvas import Canvas
from tendond.cli.watch.rod import sketch
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, Status

MODE_STYLES = {
    Mode.STARTING: "black on white",
    Mode.IDLE: "black on white",
    Mode.PROBE: "black on yellow",
    Mode.PRETENSION: "black on yellow",
    Mode.TRACKING: "black on green",
    Mode.RELEASING: "black on yellow",
    Mode.FAULT: "bold white on red",
}
LEFT_WIDTH = 42
LEAST_PLOT = 24
"""Characters across below which plots are left out."""

LEAST_HEIGHT = 8
LABEL = 10
BLOCKS = " ▏▎▍▌▋▊▉█"
SPARKS = "▁▂▃▄▅▆▇█"
DIM, GOOD, BAD, WARN = "dim", "green", "bold red", "yellow"
SCALES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)


def frame(seen: Seen, config: RigConfig, now: float, width: int, height: int) -> Text:
    """A frame that fits.

    Args:
        seen: so far.
        config: of the rig: its name, limits and length.
        now: of the clock that `seen` was filled by [s].
        width, height: of the terminal, in characters.
    """
    body = max(1, height - 1)
    left_width = min(LEFT_WIDTH, width)
    left = _left(seen, config, now, left_width)[:body]
    right = _plots(seen, config, now, width - left_width - 1, body) if width - left_width - 1 >= LEAST_PLOT else []
    rows = [_head(seen, config, now, width)]
    for i in range(max(len(left), len(right))):
        row = left[i] if i < len(left) else Text()
        if i < len(right):
            row = row.copy()
            row.append(" " * (left_width + 1 - row.cell_len))
            row.append(right[i])
        rows.append(row)
    for row in rows:
        row.truncate(width, overflow="ellipsis")
    return Text("\n", no_wrap=True, end="").join(rows[:height])


def line(seen: Seen, config: RigConfig, now: float) -> str:
    """The same in a line."""
    status = seen.status
    if status is None or seen.is_silent(now):
        return _waiting(config)
    parts = [f"{status.mode.value} ({status.reason})", f"tip {' '.join(_tip(seen).split())}"]
    if seen.error is not None:
        parts.append(f"to target {_millimetre(seen.error)} mm")
    command = seen.command or status
    parts.append(f"tension {' '.join(f'{value:.2f}' for value in command.tension)} N")
    parts.append(f"displacement {_millimetres(command.displacement)} mm")
    parts.append(f"cycle {status.loop.cycle_ms_median:.2f} ms, {status.loop.missed_ticks} missed")
    return ", ".join(parts)


def _waiting(config: RigConfig) -> str:
    return f"waiting for the controller of rig '{config.rig.name}' at {config.bus.endpoint}"


def _head(seen: Seen, config: RigConfig, now: float, width: int) -> Text:
    """Rig, mode, reason."""
    status = seen.status
    if status is None or seen.is_silent(now):
        return Text(f" {_waiting(config)} ", style=MODE_STYLES[Mode.PRETENSION])
    head = Text.assemble((f" {status.rig} ", "bold"), (f" {status.mode.value.upper()} ", MODE_STYLES[status.mode]))
    head.append(f" {status.reason} ", style=BAD if status.mode is Mode.FAULT else "")
    rest = f"{status.law.replace('_', ' ')}, {status.feedback} "
    if head.cell_len + len(rest) <= width:
        head.append(" " * (width - head.cell_len - len(rest)))
        head.append(rest, style=DIM)
    return head


def _left(seen: Seen, config: RigConfig, now: float, width: int) -> list[Text]:
    """Numbers and bars."""
    status = seen.status
    rows = [Text()]
    if status is not None and status.mode is Mode.FAULT:
        rows += [Text(part, style=BAD) for part in _wrapped(status.reason, width)]
    if seen.tendons is not None and seen.tendons.fault:
        rows += [Text(part, style=BAD) for part in _wrapped(f"servos: {seen.tendons.fault}", width)]
    occluded = seen.pose is not None and not seen.pose.valid
    rows.append(_row("tip", Text(f"{_tip(seen)}{' hidden' if occluded else ''}", WARN if occluded else "")))
    rows.append(_row("target", Text("-" if status is None else f"{_padded(status.target)} mm")))
    rows.append(_row("distance", _distance(seen, width - LABEL)))
    rows.append(Text())
    rows += _tendons(seen, config, width)
    rows.append(Text())
    rows.append(_row("pose", _stream(seen.pose_stream, now)))
    rows.append(_row("command", _stream(seen.command_stream, now)))
    rows.append(_row("tendons", _stream(seen.tendons_stream, now)))
    rows.append(Text())
    if status is not None:
        rows += _health(status)
    return rows


def _row(label: str, value: Text) -> Text:
    return Text.assemble((f" {label:<{LABEL - 1}}", DIM), value)


def _wrapped(text: str, width: int) -> list[str]:
    return [f" {part}" for part in textwrap.wrap(text, max(8, width - 2))][:4]


def _tip(seen: Seen) -> str:
    return "none yet" if seen.pose is None else f"{_padded(seen.pose.position)} mm"


def _padded(values: Sequence[float]) -> str:
    return " ".join(f"{_millimetre(value):>7}" for value in values)


def _millimetres(values: Sequence[float]) -> str:
    return " ".join(_millimetre(value) for value in values)


def _millimetre(value: float) -> str:
    return f"{round(1e3 * value, 1) + 0.0:.1f}"  # no -0.0


def _distance(seen: Seen, width: int) -> Text:
    if seen.error is None:
        return Text("-")
    text = Text(f"{_millimetre(seen.error):>7} mm ")
    text.append(sparkline(list(seen.errors), width - text.cell_len - 1), style="cyan")
    return text


def sparkline(values: Sequence[float], width: int) -> str:
    """The last `width` distances [m]; each step of the blocks is half a power of ten, from 0.1 mm."""
    shown = list(values)[-width:] if width > 0 else []
    steps = (math.floor(2.0 * math.log10(max(value, 1e-9) / 1e-4)) + 1 for value in shown)
    return "".join(SPARKS[min(max(step, 0), len(SPARKS) - 1)] for step in steps)


def bar(part: float, width: int) -> str:
    """A bar of `part` of the width."""
    eighths = round(8 * width * min(max(part, 0.0), 1.0))
    full = "█" * (eighths // 8)
    return (full + (BLOCKS[eighths % 8] if eighths % 8 else "")).ljust(width)


def _tendons(seen: Seen, config: RigConfig, width: int) -> list[Text]:
    """A line each: tension against its limit; displacement, commanded and reported."""
    state, limits = seen.tendons, config.limits
    command = seen.command or seen.status
    if command is None:
        return [_row("tension", Text("-"))]
    size = max(4, width - 4 - 1 - 8 - 2 * 9)
    heading = f" of {limits.tension_max:g} N"
    rows = [Text(f"{heading:<{size + 5}}{'N':>8}{'mm':>9}{'is at':>9}", style=DIM)]
    pulls = (config.control.agonist, config.control.antagonist)
    for index, (tension, displacement) in enumerate(zip(command.tension, command.displacement, strict=True)):
        part = tension / limits.tension_max
        way = limits.displacement_max if displacement >= 0.0 else -limits.displacement_min
        reported = state.displacement[index : index + 1] if state is not None else ()
        rows.append(
            Text.assemble(
                (f" {index:>2} ", "" if index in pulls else DIM),
                (bar(part, size) + "▏", BAD if part > 0.98 else WARN if part > 0.8 else GOOD),
                f"{tension:8.2f}",
                (f"{_millimetre(displacement):>9}", BAD if abs(displacement) > 0.98 * way else ""),
                "".join(f"{_millimetre(value):>9}" for value in reported),
            )
        )
    if seen.command is not None and not seen.command.armed:
        rows.append(Text(" disarmed, torque off", style=DIM))
    return rows


def _stream(stream: Stream, now: float) -> Text:
    if math.isinf(stream.at):
        return Text("none yet", style=DIM)
    age = now - stream.at
    late = age > SILENT_SECONDS
    return Text(f"{stream.rate(now):6.1f} Hz" + (f", last {age:.0f} s ago" if late else ""), style=WARN if late else "")


def _health(status: Status) -> list[Text]:
    loop = status.loop
    rejected = ", ".join(f"{count} {reason}" for reason, count in sorted(status.rejected.items(), key=_most))
    days = "" if loop.log_days_left is None else f", room for {loop.log_days_left:.1f} days"
    log = loop.log_error or f"{loop.log_dropped} entries dropped{days}"
    return [
        _row("cycle", Text(f"{loop.cycle_ms_median:.2f} ms, p99 {loop.cycle_ms_p99:.2f} ms")),
        _row("cycles", Text(f"{loop.cycles}, {loop.missed_ticks} missed", style=WARN if loop.missed_ticks else "")),
        _row("rejected", Text(rejected or "nothing", style=WARN if rejected else "")),
        *([_row("refused", Text(status.refused, style=BAD))] if status.refused else []),
        _row("log", Text(log, style=BAD if loop.log_error else WARN if loop.log_dropped else "")),
    ]


def _most(item: tuple[str, int]) -> int:
    return -item[1]


def _plots(seen: Seen, config: RigConfig, now: float, width: int, height: int) -> list[Text]:
    """The projections, one above the other; beside each other where that is larger."""
    if height < 2 * LEAST_HEIGHT:
        return _plot(seen, config, now, 0, width, height)
    if width >= 3 * height and width >= 2 * LEAST_PLOT:
        half = (width - 1) // 2
        pairs = zip(_plot(seen, config, now, 0, half, height), _plot(seen, config, now, 1, half, height), strict=True)
        return [Text(" ").join(pair) for pair in pairs]
    half = height // 2
    return _plot(seen, config, now, 0, width, height - half) + _plot(seen, config, now, 1, width, half)


def _plot(seen: Seen, config: RigConfig, now: float, across: int, width: int, height: int) -> list[Text]:
    """A projection in a frame: rod, trail, target and tip."""
    length = config.rod.length
    is_old = seen.pose_stream.at < now - SILENT_SECONDS
    canvas = Canvas(width - 2, height - 2, (-length, length, -0.25 * length, 1.05 * length))
    canvas.line([(-length, 0.0), (length, 0.0)], DIM)
    for point in seen.trail:
        canvas.dot((point[across], point[2]), "yellow")
    if seen.pose is not None:
        canvas.line(sketch(seen.pose.position, seen.pose.orientation, length, across), DIM if is_old else "cyan")
    canvas.mark((0.0, 0.0), "▲", "")
    if seen.status is not None:
        canvas.mark((seen.status.target[across], seen.status.target[2]), "+", "bold green")
    if seen.pose is not None:
        canvas.mark((seen.pose.position[across], seen.pose.position[2]), "●", DIM if is_old else "bold yellow")
    inside = width - 2
    cell = 2 * canvas.dot_size
    scale = max((s for s in SCALES if s <= 0.3 * inside * cell), default=SCALES[0])
    ruler = f"{1e3 * scale:g} mm ├{'─' * max(0, round(scale / cell) - 2)}┤"
    title = f" {'xy'[across]}-z "
    rows = [Text(f"┌{title:─<{inside}}┐", style=DIM)]
    rows += [Text.assemble(("│", DIM), row, ("│", DIM)) for row in canvas.lines()]
    rows.append(Text(f"└{ruler if len(ruler) < inside else '':─>{inside}}┘", style=DIM))
    return rows
