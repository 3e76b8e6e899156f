"""Ticks of recorded cycles, without reading the rest of them; and which are missing."""

import re
from itertools import pairwise

from pydantic import ValidationError

from tendond.daemon.control.snapshot import StateSnapshot

_TICK = re.compile(rb'^\{"version":[12],"tick":(\d+),')


def tick_of(data: bytes) -> int | None:
    """Read the tick of a cycle's message as the recorder writes it; none for other messages and versions."""
    found = _TICK.match(data)
    return None if found is None else int(found[1])


def left_out_before(data: bytes) -> tuple[int, int] | None:
    """Read the first and last cycle left out on purpose before a state; none without, or of another version."""
    try:
        snapshot = StateSnapshot.model_validate_json(data)
    except ValidationError:
        return None
    return (snapshot.tick - snapshot.left_out, snapshot.tick - 1) if snapshot.left_out else None


def ranges(ticks: list[int]) -> list[tuple[int, int]]:
    """List the first and last tick of each gap between ticks in ascending order."""
    return [(a + 1, b - 1) for a, b in pairwise(ticks) if b > a + 1]


def shown(stretch: tuple[int, int]) -> str:
    """Format a stretch of ticks for people."""
    first, last = stretch
    return f"cycle {first}" if first == last else f"cycles {first} to {last}"
