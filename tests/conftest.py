"""How the tests are spread over processes (`pytest -n 2`, as `make test` does).

Tests with real processes and wires wait for the clock most of the time, but want a processor when it strikes: they run
one after the other, in one process. The others compute, file by file, in whichever process is free.
"""

from pathlib import Path
from typing import Any

import pytest

REAL_TIME = ("sil", "rig")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """The tests of real time first: they take longest."""
    items.sort(key=lambda item: not is_real_time(item.path))


def is_real_time(path: Path) -> bool:
    """Whether a file of tests waits for the clock."""
    return not {*path.parts}.isdisjoint(REAL_TIME)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """See the module."""
    from xdist.scheduler import LoadScopeScheduling  # type: ignore[import-untyped]

    class Scheduling(LoadScopeScheduling):  # type: ignore[misc]
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.split("::", 1)[0]
            return "real time" if is_real_time(Path(file)) else file

    return Scheduling(config, log)
