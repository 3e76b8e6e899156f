"""State of a law between two cycles, with the name of the law: snapshots are read by that law's own type."""

import math
from dataclasses import dataclass
from typing import Any

from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.snapshot import from_plain, to_plain


@dataclass(frozen=True)
class LawState:
    """State of a law.

    Attributes:
        law: name of the law.
        value: state, of the law's own type.
    """

    law: str
    value: Any

    def to_snapshot(self) -> dict[str, Any]:
        """Return it as JSON has it."""
        return {"law": self.law, "value": to_plain(self.value)}

    @classmethod
    def from_snapshot(cls, data: dict[str, Any], setup: Any) -> "LawState":
        """Make the state that `to_snapshot` wrote."""
        return cls(data["law"], from_plain(LAWS[data["law"]].state, data["value"], setup))

    def logged(self) -> dict[str, float | tuple[float, ...]]:
        """Return the finite numbers in it by field, arrays flattened, for the record and for plots."""
        fields = self.value if isinstance(self.value, dict) else getattr(self.value, "__dict__", {"value": self.value})
        return {name: found for name, value in fields.items() if (found := _numbers(value)) is not None}


def _numbers(value: Any) -> float | tuple[float, ...] | None:
    """Return a number as it is, a sequence or an array of numbers as a flat tuple; none for all else."""
    try:
        numbers = (
            tuple(float(one) for one in value.ravel())
            if hasattr(value, "ravel")
            else (tuple(float(one) for one in value) if isinstance(value, (tuple, list)) else float(value))
        )
    except (TypeError, ValueError):
        return None
    finite = all(map(math.isfinite, numbers)) if isinstance(numbers, tuple) else math.isfinite(numbers)
    return numbers if finite else None
