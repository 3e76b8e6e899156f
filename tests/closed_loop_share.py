"""Time the plant's part of a closed-loop run: `python -m tests.closed_loop_share`.

Nominal points of `tendond study robustness`, with the general rod as the plant. Prints a Markdown table of medians of
processor time: the run, the part of it in the plant's steps, and in their kernel.
"""

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any
from unittest.mock import patch

import numpy as np

from tendond.daemon.control.laws import LAWS
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.drivers.simulator.rods import GeneralPlantRod
from tendond.offline.robustness.open_loop import by_general_rod
from tendond.offline.robustness.plants import IDLE_CYCLES, impact_tick, rig_of
from tendond.offline.robustness.points import Point
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.requests import ControlAction

RUNS = 7

ARM: dict[str, Any] = {
    "rod": {"preset": "rao-2021"},
    "control": {"law": "sensitivity"},
    "reference": {"across": 0.12},
    "limits": {"tension_max": 6.0},
    "pretension": {"tension_min": 0.1},
}


class Timer:
    """Time spent in functions that it has wrapped [s]."""

    def __init__(self) -> None:
        self.total = 0.0

    def around(self, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return the function, timed."""

        def timed(*given: Any, **more: Any) -> Any:
            start = time.process_time()
            try:
                return function(*given, **more)
            finally:
                self.total += time.process_time() - start

        return timed


def run_once(base: RigConfig, law: str) -> tuple[float, float, float]:
    """Run a nominal point; return its time, the plant's steps' and their kernel's [s]."""
    config, steps, kernel = by_general_rod(rig_of(base, Point("", law, "force"), 0)), Timer(), Timer()
    begin = GeneralPlantRod.__init__

    def started(plant: GeneralPlantRod, *given: Any) -> None:
        begin(plant, *given)
        bound = plant.strain_rod._advance
        timed = kernel.around(lambda *arguments: bound.call(*arguments))
        vars(plant.strain_rod)["_advance"] = SimpleNamespace(call=timed)

    with (
        patch.object(GeneralPlantRod, "__init__", started),
        patch.object(GeneralPlantRod, "step", steps.around(GeneralPlantRod.step)),
    ):
        start = time.process_time()
        for _ in watched_loop(config, impact_tick(base), {IDLE_CYCLES: ControlAction.ARM}):
            pass
        return time.process_time() - start, steps.total, kernel.total


def main() -> None:
    """Print the table."""
    print("| robot, law | run s | plant's steps % | their kernel % | faster at most, with plants for nothing |")
    print("| --- | --- | --- | --- | --- |")
    arm = check_config(ARM, "arm")
    for name, base, law in (
        ("arm of two sections, sensitivity", arm, "sensitivity"),
        *((f"the paper's, {law}", RigConfig(), law) for law in LAWS if law != "sensitivity"),
    ):
        run_once(base, law)
        run, steps, kernel = np.median([run_once(base, law) for _ in range(RUNS)], axis=0)
        gain = 1.0 / (1.0 - steps / run)
        print(f"| {name} | {run:.2f} | {100 * steps / run:.0f} | {100 * kernel / run:.0f} | {gain:.2f} |")


if __name__ == "__main__":
    main()
