"""Hints for values that were given in a thousandth of their unit: lengths in millimetres, masses in grams."""

UNITS = {"m": "lengths are in metres", "kg": "masses are in kilograms"}


def unit_hint(value: float, largest: float, unit: str) -> str:
    """Ask whether a value that is too large was meant in a thousandth of its unit; empty for another unit.

    >>> unit_hint(300.0, 1.0, "m")
    '; lengths are in metres: did you mean 0.3?'

    Args:
        value: as given [unit].
        largest: that is allowed [unit].
        unit: of both.
    """
    if unit not in UNITS:
        return ""
    meant = f": did you mean {value / 1e3:g}?" if 0.0 < abs(value) / 1e3 <= largest else ""
    return f"; {UNITS[unit]}{meant}"
