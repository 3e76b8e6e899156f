"""Hints at another unit: a value that would be allowed in millimetres, grams, degrees or the like."""

import math
from collections.abc import Callable

OTHERS: dict[str, tuple[tuple[str, float], ...]] = {
    "m": (("mm", 1e-3),),
    "m/s": (("mm/s", 1e-3),),
    "kg": (("g", 1e-3),),
    "s": (("ms", 1e-3),),
    "Pa": (("GPa", 1e9), ("MPa", 1e6)),
    "kg/m^3": (("g/cm^3", 1e3),),
    "rad": (("degrees", math.pi / 180.0),),
    "-": (("per cent", 1e-2),),
}
"""Units that people measure in, and their size, by the unit of a key."""


def unit_hint(value: object, unit: str, allowed: Callable[[float], bool]) -> str:
    """Return '; if it is in mm, write 0.3' where a refused value would be allowed in another unit; else nothing.

    Args:
        value: that is refused. unit: of its key. allowed: whether a value of the key's unit is.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    for name, size in OTHERS.get(unit, ()):
        if allowed(value * size):
            return f"; if it is in {name}, write {value * size:.6g}"
    return ""
