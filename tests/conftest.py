"""Distribution of the tests over processes (`pytest -n 4`, as `make test` does).

Tests with real processes (`sil`) and on emulated wires (`rig`) mostly wait for the clock: they run in two processes,
one test after the other, as more robots at once are late on two slow processors. The rest compute; they are
distributed file by file to whichever process is free, the longest first, so that none runs alone at the end, and with a
lower priority, so that those that wait are not late.
"""

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

REAL_TIME = ("sil", "rig")

# Before the first import of NumPy: a second thread helps none of these small matrices, and spins while it waits.
# Child processes inherit it. With it the tests of the margin take a tenth of the processor's time.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# What a command prints does not depend on how busy the machine is. Child processes inherit it.
os.environ.setdefault("TENDOND_PROGRESS", "off")

LONGEST = (
    "deploy/test_install",
    "cluster/test_robustness_cluster",
    "control/test_cycle_bound",
    "cli/test_terminal",
    "control/test_cycle_properties",
    "commissioning/test_wiring",
    "plants/test_weights",
    "offline/test_robustness_run",
    "monitors/test_monitors",
    "offline/test_paper",
    "runtime/test_thinning",
    "strain/test_analysis",
    "strain/test_accuracy",
    "drivers/test_servo_contact",
    "model/test_margin_tip",
    "offline/test_pages",
    "identification/test_identify_logs",
    "identification/test_identify_fit",
    "smoothing/test_smoother",
    "smoothing/test_batch",
)
"""Files of more than about ten seconds of processor time, the longest first."""

BESIDE = {"loop": "loop and plant", "plant": "loop and plant"}
"""Folders of real-time tests that run in the other of the two processes."""

COMPUTING, ON_WIRES = 19, -5
"""Niceness of the tests that compute, and, where it is permitted, of those on wires: the robot on them is a thread."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the real-time tests first, which take longest, then the longest files."""
    items.sort(key=lambda item: (not is_real_time(item.path), place_of(item.path)))


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Give way to the real-time tests of another process."""
    with suppress(PermissionError):  # to raise it again is root's
        wanted = ON_WIRES if "rig" in item.path.parts else 0 if is_real_time(item.path) else COMPUTING
        os.setpriority(os.PRIO_PROCESS, 0, wanted)


def is_real_time(path: Path) -> bool:
    """Return true for a file of tests that wait for the clock."""
    return not {*path.parts}.isdisjoint(REAL_TIME)


def place_of(path: Path) -> int:
    """Return the place of a file among the longest ones; the others come after them."""
    name = f"{path.parent.name}/{path.stem}"
    return LONGEST.index(name) if name in LONGEST else len(LONGEST)


def scope_of(path: Path) -> str:
    """Name what runs in one process: half of the real-time tests, or a single file."""
    return BESIDE.get(path.parent.name, "bus and rig") if is_real_time(path) else str(path)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """See the module."""
    from xdist.scheduler import LoadScopeScheduling  # type: ignore[import-untyped]

    class Scheduling(LoadScopeScheduling):  # type: ignore[misc]
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.split("::", 1)[0]
            return scope_of(Path(file))

    config.option.loadscopereorder = False  # by the number of tests, which says little about their time
    return Scheduling(config, log)
