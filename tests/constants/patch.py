"""Other values for constants of `daemon.control`, in every module that has imported them."""

import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import ModuleType
from typing import Any
from unittest.mock import patch

PACKAGE = "tendond.daemon.control."
HOMES = (f"{PACKAGE}commissioning.", f"{PACKAGE}reference.")
"""Where the constants are defined; another module may have another constant of the same name."""


def modules_of(packages: str | tuple[str, ...], name: str) -> list[ModuleType]:
    """List the modules of packages that have a constant: its own, and those that import it."""
    return [module for key, module in sys.modules.items() if key.startswith(packages) and name in vars(module)]


def own_value(name: str) -> Any:
    """Return the value that a constant has.

    Raises:
        ValueError: the name stands for several constants, or for none.
    """
    values = [getattr(module, name) for module in modules_of(HOMES, name)]
    if not values or any(one is not values[0] for one in values):
        raise ValueError(f"{name} is {len(values)} constants in {' and '.join(HOMES)}")
    return values[0]


@contextmanager
def changed(name: str, value: object) -> Iterator[None]:
    """Set a constant to a value meanwhile."""
    with ExitStack() as stack:
        own = own_value(name)
        for module in modules_of(PACKAGE, name):
            if getattr(module, name) is own:
                stack.enter_context(patch.object(module, name, value))
        yield
