"""The planar reference's constants, with weights hung on the tip and with a push.

A row has the error of the tip at the end, and the time to come within 2 mm.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor

import numpy as np

from tendond.drivers.simulator.lockstep import watched_loop
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction
from tests.constants.patch import changed, own_value
from tests.constants.values import NONE, Neighbours, in_words, print_table, values_of

REFERENCE: Neighbours = {
    "OFFSET_MAX": (0.04, 0.2, 0.4),
    "FOLLOW_RATE": (0.05, 1.0),
    "AT_TARGET": (0.02, 0.3),
    "PAST_TARGET": (0.25, NONE),
}
"""Constants of `daemon.control.reference`, and values beside their own."""

WEIGHTS = [(across, grams) for across in (0.34, 0.352) for grams in (50, 100)]
"""Target across the rod [m], 0.36 m being the largest, and weight [g]."""

SOFT_AND_PUSHED = """
[simulator.rod]
youngs_modulus = 1.615e11
bending_damping = [0.004, 0.004, 0.004]
[[simulator.impacts]]
time = 1.0
duration = 0.05
force = [0.0, 0.0, 10.0]
"""
CYCLES, SETTLED = 1000, 2e-3
"""Cycles of a run with a weight or a push; distance from the target at which it has settled [m]."""


def run_reference(case: tuple[str, float, str, float]) -> str:
    """Run a configuration with one value: error of the tip across the rod [mm] and time to settle [s], or the fault."""
    name, value, text, across = case
    with changed(name, value):
        trace = list(watched_loop(parse_config(text, "constants"), CYCLES, {5: ControlAction.ARM}))
    if trace[-1].record.mode is not Mode.TRACKING:
        return trace[-1].record.reason.split(":")[0]
    away = np.abs(np.array([watched.truth.position[0] for watched in trace]) - across)
    last = np.flatnonzero(away > SETTLED)[-1]
    settling = "" if last == CYCLES - 1 else f", {0.01 * last - 1.0:.2f} s"
    return f"{1e3 * away[-1]:.1f} mm{settling}"


def print_reference(names: Sequence[str], pool: Executor) -> None:
    """Print the table of the constants among `names`."""
    weights = [
        (f"[reference]\nacross = {across}\n[simulator.weight]\nmass = {grams / 1e3}\ntime = 1.0\n", across)
        for across, grams in WEIGHTS
    ]
    runs = [*weights, (f"[reference]\nacross = 0.34\n{SOFT_AND_PUSHED}", 0.34)]
    own = {name: own_value(name) for name in REFERENCE}

    def rows() -> Iterator[list[str]]:
        for name, value in values_of(names, own, REFERENCE):
            yield [name, in_words(value), *pool.map(run_reference, [(name, value, *one) for one in runs])]

    cases = [f"{grams} g at {across:g} m" for across, grams in WEIGHTS]
    print_table(("constant", "value", *cases, "push on a soft arm"), rows())
