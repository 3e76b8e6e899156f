"""Compilation of the kernels before they are needed, in child processes: they end at once with Ctrl-C.

numba stays in the compiler for seconds, in which no signal is handled; a process that only waits handles it.
"""

import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence

from tendond.daemon.errors import DaemonError
from tendond.schemas.config.rig import RigConfig

TENDONS = 4
"""Number of tendons of the paper's robot."""

SHOOTING, TRAJECTORIES, GENERAL, FILTER, BODY = "shooting", "trajectories", "general", "filter", "body"

NAMES = {SHOOTING: "shooting rod", GENERAL: "general rod"}
"""Name for people of a list of parts, by its first."""

ALL = ((SHOOTING, TRAJECTORIES), (GENERAL, FILTER, BODY))
"""Parts of `tendond.model.warm`; each list is compiled in a process of its own."""

Progress = Callable[[str, int, str], None]
"""Name of the rod, functions compiled until now, and the last one's name; from a thread of each list of parts."""


def parts_of(config: RigConfig) -> tuple[tuple[str, ...], ...]:
    """Return the parts that a controller and a simulator with this configuration need, and `tendond config check`."""
    from tendond.drivers.simulator.rods import plant_solver
    from tendond.model.rods.selection import source_of

    solvers = {source_of(config).solver, plant_solver(config.simulator), GENERAL}
    more = (*((FILTER,) if config.observer.kind == "kalman" else ()), *((BODY,) if config.safety is not None else ()))
    return tuple((solver, *(more if solver == GENERAL else ())) for solver in NAMES if solver in solvers)


def compile_kernels(parts: Sequence[Sequence[str]], tendons: int, progress: Progress) -> dict[str, float]:
    """Compile what is not cached; return the time that each list of parts took [s], by the rod's name.

    Args:
        parts: lists of names in `tendond.model.warm.PARTS`, compiled beside each other.
        tendons: number of tendons; the shooting rod has kernels for up to 4, 8 and 16.
        progress: called for each function.

    Raises:
        DaemonError: a process failed, with its last line.
    """
    start = time.monotonic()
    children = {NAMES[part[0]]: _start(part, tendons) for part in parts}
    took: dict[str, float] = {}
    errors: dict[str, str] = {}

    def follow(name: str, child: "subprocess.Popen[str]") -> None:
        assert child.stdout is not None
        with child.stdout as lines:
            for count, line in enumerate(lines, 1):
                progress(name, count, line.strip())
                errors[name] = line.strip()
        if child.wait() == 0:
            errors.pop(name, None)
        took[name] = time.monotonic() - start

    threads = [threading.Thread(target=follow, args=item, daemon=True) for item in children.items()]
    try:
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    finally:
        for child in children.values():
            child.kill()
            child.wait()
    for name, line in errors.items():
        raise DaemonError(f"kernels of the {name} could not be compiled: {line}")
    return took


def _start(part: Sequence[str], tendons: int) -> "subprocess.Popen[str]":
    """Start the process that compiles these parts; the terminal's Ctrl-C does not reach it."""
    command = [sys.executable, "-P", "-m", "tendond.model.warm", str(tendons), *part]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True
    )
