"""Frame of the live view, as text of a given size; and a line, for output that is not a terminal."""

import math

from rich.text import Text

from tendond.cli.watch.bus_snapshot import SILENT_SECONDS, BusSnapshot, Stream
from tendond.cli.watch.canvas import Canvas
from tendond.cli.watch.health import (
    BAD,
    DIM,
    GOOD,
    LABEL,
    WARN,
    folded,
    health_rows,
    labelled,
    sensors_in_words,
    tuned_in_words,
)
from tendond.cli.watch.rod import sketch
from tendond.cli.watch.text import bar, millimetre, millimetres, padded, sparkline, wrapped
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, Status
from tendond.schemas.remedies import clearing

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
MIN_PLOT_WIDTH = 24
"""Width in characters below which plots are omitted."""

MIN_PLOT_HEIGHT = 8
SCALES = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)


def frame(snapshot: BusSnapshot, config: RigConfig, now: float, width: int, height: int, option: str = "") -> Text:
    """Draw a frame that fits.

    Args:
        snapshot: the bus snapshot.
        config: the rig's configuration, for its name, limits and length.
        now: time on the clock of `snapshot` [s].
        width, height: size of the terminal, in characters.
        option: that names the rig, in the command that clears a fault.
    """
    body = max(1, height - 1)
    left_width = min(LEFT_WIDTH, width)
    left = _left(snapshot, config, now, left_width, option)[:body]
    right = (
        _plots(snapshot, config, now, width - left_width - 1, body) if width - left_width - 1 >= MIN_PLOT_WIDTH else []
    )
    rows = [_head(snapshot, config, now, width)]
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


def _to_clear(status: Status, config: RigConfig, option: str) -> str:
    return clearing(status.reason, option, has_servos=config.servo is not None)


def line(snapshot: BusSnapshot, config: RigConfig, now: float, option: str = "") -> str:
    """Write the frame's numbers in a line; `option` as for `frame`."""
    status = snapshot.status
    if status is None or snapshot.is_silent(now):
        return _waiting(config)
    parts = [f"{status.mode.value} ({status.reason})", f"tip {' '.join(_tip(snapshot).split())}"]
    if status.mode is Mode.FAULT:
        parts.insert(1, _to_clear(status, config, option))
    if snapshot.error is not None:
        parts.append(f"to target {millimetre(snapshot.error)} mm")
    command = snapshot.command or status
    parts.append(f"tension {' '.join(f'{value:.2f}' for value in command.tension)} N")
    if status.tip_tension:
        parts.append(f"at the tip {' '.join(f'{value:.2f}' for value in status.tip_tension)} N")
    parts.append(f"displacement {millimetres(command.displacement)} mm")
    if status.filter:
        parts.append(f"filter: {status.filter.in_words}")
    if status.sensors:
        parts.append(f"sensors {'; '.join(sensors_in_words(status))}")
    if status.tuned:
        parts.append(f"tuned {'; '.join(tuned_in_words(status))}")
    parts.append(f"cycle {status.loop.cycle_ms_median:.2f} ms, {status.loop.missed_ticks} missed")
    return ", ".join(parts)


def _waiting(config: RigConfig) -> str:
    return f"waiting for the controller of rig '{config.rig.name}' at {config.bus.endpoint}"


def _head(snapshot: BusSnapshot, config: RigConfig, now: float, width: int) -> Text:
    """Write rig, mode and reason."""
    status = snapshot.status
    if status is None or snapshot.is_silent(now):
        return Text(f" {_waiting(config)} ", style=MODE_STYLES[Mode.PRETENSION])
    head = Text.assemble((f" {status.rig} ", "bold"), (f" {status.mode.value.upper()} ", MODE_STYLES[status.mode]))
    head.append(f" {status.reason} ", style=BAD if status.mode is Mode.FAULT else "")
    rest = f"{status.law.replace('_', ' ')}, {status.feedback} "
    if head.cell_len + len(rest) <= width:
        head.append(" " * (width - head.cell_len - len(rest)))
        head.append(rest, style=DIM)
    return head


def _left(snapshot: BusSnapshot, config: RigConfig, now: float, width: int, option: str) -> list[Text]:
    """Write numbers and bars."""
    status = snapshot.status
    rows = [Text()]
    if status is not None and status.mode is Mode.FAULT:
        rows += [Text(part, style=BAD) for part in wrapped(status.reason, width)]
        rows += [Text(part, style=WARN) for part in wrapped(_to_clear(status, config, option), width)]
    if snapshot.tendons is not None and snapshot.tendons.fault:
        rows += [Text(part, style=BAD) for part in wrapped(f"servos: {snapshot.tendons.fault}", width)]
    occluded = snapshot.pose is not None and not snapshot.pose.valid
    rows.append(labelled("tip", Text(f"{_tip(snapshot)}{' hidden' if occluded else ''}", WARN if occluded else "")))
    rows.append(labelled("target", Text("-" if status is None else f"{padded(status.target)} mm")))
    rows.append(labelled("distance", _distance(snapshot, width - LABEL)))
    rows.append(Text())
    rows += _tendons(snapshot, config, width)
    rows.append(Text())
    rows.append(labelled("pose", _stream(snapshot.pose_stream, now)))
    rows.append(labelled("command", _stream(snapshot.command_stream, now)))
    rows.append(labelled("tendons", _stream(snapshot.tendons_stream, now)))
    rows.append(Text())
    if status is not None:
        rows += health_rows(status)
    return [part for row in rows for part in folded(row, width)]


def _tip(snapshot: BusSnapshot) -> str:
    return "none yet" if snapshot.pose is None else f"{padded(snapshot.pose.position)} mm"


def _distance(snapshot: BusSnapshot, width: int) -> Text:
    if snapshot.error is None:
        return Text("-")
    text = Text(f"{millimetre(snapshot.error):>7} mm ")
    text.append(sparkline(list(snapshot.errors), width - text.cell_len - 1), style="cyan")
    return text


def _tendons(snapshot: BusSnapshot, config: RigConfig, width: int) -> list[Text]:
    """Write a line per tendon: tension against its limit; displacement, commanded and measured."""
    state, limits = snapshot.tendons, config.limits
    command = snapshot.command or snapshot.status
    if command is None:
        return [labelled("tension", Text("-"))]
    at_tip = () if snapshot.status is None else snapshot.status.tip_tension
    size = max(4, width - 4 - 1 - 8 - 2 * 9 - (8 if at_tip else 0))
    tuned = None if snapshot.status is None else snapshot.status.tuned.get("limits.tension_max")
    tension_max = limits.tension_max if tuned is None else tuned.value
    heading = f" of {tension_max:.3g} N"
    extra = f"{'at tip':>8}" if at_tip else ""
    rows = [Text(f"{heading:<{size + 5}}{'N':>8}{extra}{'mm':>9}{'measured':>9}", style=DIM)]
    pulls = (config.control.agonist, config.control.antagonist)
    for index, (tension, displacement) in enumerate(zip(command.tension, command.displacement, strict=True)):
        part = tension / tension_max
        limit = limits.displacement_max if displacement >= 0.0 else -limits.displacement_min
        reported = state.displacement[index : index + 1] if state is not None else ()
        rows.append(
            Text.assemble(
                (f" {index:>2} ", "" if index in pulls else DIM),
                (bar(part, size) + "▏", BAD if part > 0.98 else WARN if part > 0.8 else GOOD),
                f"{tension:8.2f}",
                "".join(f"{value:8.2f}" for value in at_tip[index : index + 1]),
                (f"{millimetre(displacement):>9}", BAD if abs(displacement) > 0.98 * limit else ""),
                "".join(f"{millimetre(value):>9}" for value in reported),
            )
        )
    if snapshot.command is not None and not snapshot.command.armed:
        rows.append(Text(" disarmed, torque off", style=DIM))
    return rows


def _stream(stream: Stream, now: float) -> Text:
    if math.isinf(stream.at):
        return Text("none yet", style=DIM)
    age = now - stream.at
    late = age > SILENT_SECONDS
    return Text(f"{stream.rate(now):6.1f} Hz" + (f", last {age:.0f} s ago" if late else ""), style=WARN if late else "")


def _plots(snapshot: BusSnapshot, config: RigConfig, now: float, width: int, height: int) -> list[Text]:
    """Draw both projections, one above the other, or side by side if that is larger."""
    if height < 2 * MIN_PLOT_HEIGHT:
        return _plot(snapshot, config, now, 0, width, height)
    if width >= 3 * height and width >= 2 * MIN_PLOT_WIDTH:
        half = (width - 1) // 2
        pairs = zip(
            _plot(snapshot, config, now, 0, half, height), _plot(snapshot, config, now, 1, half, height), strict=True
        )
        return [Text(" ").join(pair) for pair in pairs]
    half = height // 2
    return _plot(snapshot, config, now, 0, width, height - half) + _plot(snapshot, config, now, 1, width, half)


def _plot(snapshot: BusSnapshot, config: RigConfig, now: float, across: int, width: int, height: int) -> list[Text]:
    """Draw a projection in a frame: rod, trail, target and tip."""
    length = config.rod.length
    is_old = snapshot.pose_stream.at < now - SILENT_SECONDS
    canvas = Canvas(width - 2, height - 2, (-length, length, -0.25 * length, 1.05 * length))
    canvas.line([(-length, 0.0), (length, 0.0)], DIM)
    for point in snapshot.trail:
        canvas.dot((point[across], point[2]), "yellow")
    if snapshot.pose is not None:
        canvas.line(
            sketch(snapshot.pose.position, snapshot.pose.orientation, length, across), DIM if is_old else "cyan"
        )
    canvas.mark((0.0, 0.0), "▲", "")
    if snapshot.status is not None:
        canvas.mark((snapshot.status.target[across], snapshot.status.target[2]), "+", "bold green")
    if snapshot.pose is not None:
        canvas.mark((snapshot.pose.position[across], snapshot.pose.position[2]), "●", DIM if is_old else "bold yellow")
    inside = width - 2
    cell = 2 * canvas.dot_size
    scale = max((s for s in SCALES if s <= 0.3 * inside * cell), default=SCALES[0])
    ruler = f"{1e3 * scale:g} mm ├{'─' * max(0, round(scale / cell) - 2)}┤"
    title = f" {'xy'[across]}-z "
    rows = [Text(f"┌{title:─<{inside}}┐", style=DIM)]
    rows += [Text.assemble(("│", DIM), row, ("│", DIM)) for row in canvas.lines()]
    rows.append(Text(f"└{ruler if len(ruler) < inside else '':─>{inside}}┘", style=DIM))
    return rows
