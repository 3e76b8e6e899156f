"""Table of the rules: each function is one, named by its docstring, and true where it holds."""

import struct
from collections.abc import Callable

from tests.conformance.bench import ServoBench

Rule = Callable[[ServoBench], bool]
RULES: list[tuple[str, Rule]] = []
"""Section of the manual, and rule."""


def rule(section: str) -> Callable[[Rule], Rule]:
    """Enter a rule under a section of the manual."""

    def enter(function: Rule) -> Rule:
        RULES.append((section, function))
        return function

    return enter


def two(address: int, size: int) -> bytes:
    """Return the parameters for an address and a size, two bytes each."""
    return struct.pack("<HH", address, size)
