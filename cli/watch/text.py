"""Numbers, bars and lines of the live view, as text."""

import math
import textwrap
from collections.abc import Sequence

BLOCKS = " ▏▎▍▌▋▊▉█"
SPARKS = "▁▂▃▄▅▆▇█"


def wrapped(text: str, width: int) -> list[str]:
    """Wrap a text, indented by a character, to a maximum of four lines."""
    return [f" {part}" for part in textwrap.wrap(text, max(8, width - 2))][:4]


def padded(values: Sequence[float]) -> str:
    """Format lengths [m] as millimetres, right-aligned."""
    return " ".join(f"{millimetre(value):>7}" for value in values)


def millimetres(values: Sequence[float]) -> str:
    """Format lengths [m] as millimetres."""
    return " ".join(millimetre(value) for value in values)


def millimetre(value: float) -> str:
    """Format a length [m] as millimetres."""
    return f"{round(1e3 * value, 1) + 0.0:.1f}"  # no -0.0


def sparkline(values: Sequence[float], width: int) -> str:
    """Draw the last `width` distances [m]; each step is half a power of ten, from 0.1 mm."""
    shown = list(values)[-width:] if width > 0 else []
    steps = (math.floor(2.0 * math.log10(max(value, 1e-9) / 1e-4)) + 1 for value in shown)
    return "".join(SPARKS[min(max(step, 0), len(SPARKS) - 1)] for step in steps)


def bar(part: float, width: int) -> str:
    """Draw a bar over a fraction `part` of the width."""
    eighths = round(8 * width * min(max(part, 0.0), 1.0))
    full = "█" * (eighths // 8)
    return (full + (BLOCKS[eighths % 8] if eighths % 8 else "")).ljust(width)
