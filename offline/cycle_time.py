"""How long a cycle of a configuration takes on this machine, beside its period."""

import time

import numpy as np

from tendond.daemon.control.cycle import respond
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.drivers.simulator.lockstep import watched_loop, without_probe
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

CYCLES = 40
"""Cycles of tracking that are timed."""

PART = 0.5
"""Part of the period that a cycle may take: recorder, bus and other processes need the rest. Chosen."""


def cycle_time(config: RigConfig) -> float | None:
    """Return the median processor time of a cycle while the law tracks on the simulated robot [s]; none: it does not.

    Raises:
        TendondError: the controller cannot be made, or the simulated robot has no solution.
    """
    config = without_probe(config)
    states: list[CycleState] = []
    cycles = 2 + round(config.pretension.duration / config.loop.period) + CYCLES
    trace = list(watched_loop(config, cycles, {1: ControlAction.ARM}, see_state=states.append))
    setup, times = CycleSetup.from_config(config), []
    for state, one in zip(states[:-1], trace, strict=True):
        if state.mode is Mode.TRACKING:
            start = time.thread_time()
            respond(setup, state, one.record.inputs)
            times.append(time.thread_time() - start)
    return float(np.median(times)) if times else None


def cycle_lines(config: RigConfig) -> tuple[str, str]:
    """Return what a cycle takes, in words, and a remark where that is too much of the period; either may be empty.

    Raises:
        TendondError: see `cycle_time`.
    """
    found, period = cycle_time(config), config.loop.period
    if found is None:
        return "", ""
    said = f"a cycle takes {1e3 * found:.2g} ms of {1e3 * period:g} ms on this machine"
    if found <= PART * period:
        return said, ""
    return said, (
        f"loop.period = {period:g}: {said}, with law {config.control.law}; deadlines will be missed: raise "
        "loop.period, choose another law, or with mpc fewer steps and knots"
    )
