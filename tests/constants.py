"""Give tuned constants other values and run the loop: `python -m tests.constants [NAME ...] [--processes N]`.

What the constants' docstrings say of smaller and larger values is from here. The observer's run on plants of `tendond
study robustness`: every axis, impacts among them, some corners and some random ones; a row counts the runs that meet
the study's goal. The reference's run with weights hung on the tip and with a push; a row has the error of the tip at
the end, and the time to come within 2 mm.
"""

import argparse
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import Any
from unittest.mock import patch

import numpy as np

from tendond.daemon.control.gains import observer_gains
from tendond.daemon.control.reference import planar
from tendond.drivers.simulator.lockstep import closed_loop, watched_loop
from tendond.model.estimation.observer_gains import ObserverGains
from tendond.model.rod.parameters import RodParameters
from tendond.offline.robustness.evaluate import PointResult, evaluate
from tendond.offline.robustness.points import Point, corners, points_of, sample
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

LAW, FEEDBACK, SEED = "backstepping", "force", 0
CORNER_STEP, SAMPLES = 64, 8
NONE = 1e9
"""Value of a bound that bounds nothing."""

WEIGHT, HUNG_AT, FOUND_SECONDS = 0.05, 1.5, 3.0
"""Mass of the weight [kg], time at which it is hung on, and time in which it is found [s]."""

GAINS: dict[str, tuple[float, ...]] = {
    "innovation_limit": (0.03, 0.3, NONE),
    "pull_factor": (1.0, 16.0),
    "unobservable": (0.01, 0.16),
    "lateral_variance": (0.1, 1.0),
}
"""Fields of `ObserverGains`, and values beside their own."""

REFERENCE: dict[str, tuple[float, ...]] = {
    "OFFSET_MAX": (0.04, 0.2, 0.4),
    "FOLLOW_RATE": (0.05, 1.0),
    "ARRIVED": (0.02, 0.3),
    "PAST_TARGET": (0.25, NONE),
}
"""Constants of `reference.planar`, and values beside their own."""

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


def plants() -> list[Point]:
    """List the plants, the same for every value."""
    return [
        *points_of("axes", [LAW], [FEEDBACK]),
        *corners(LAW, FEEDBACK)[::CORNER_STEP],
        *sample(LAW, FEEDBACK, SAMPLES, SEED),
    ]


@contextmanager
def changed(name: str, value: float) -> Iterator[None]:
    """Set a constant to a value, for the controllers that are made meanwhile."""
    if name in REFERENCE:
        with patch.object(planar, name, value):
            yield
        return
    changes: dict[str, Any] = {name: value}

    def gains(config: RigConfig, rod: RodParameters, *laws: str) -> ObserverGains:
        return replace(observer_gains(config, rod, *laws), **changes)

    with patch("tendond.daemon.control.setup.observer_gains", gains):
        yield


def run_plant(case: tuple[str, float, Point]) -> PointResult:
    """Run one plant with one value."""
    name, value, point = case
    with changed(name, value):
        return evaluate(RigConfig(), point, SEED)


def weight_error(name: str, value: float) -> float:
    """Hang `WEIGHT` on the resting arm; error of the estimated force after `FOUND_SECONDS`, of the weight [-]."""
    config = parse_config(f"[simulator.weight]\nmass = {WEIGHT}\ntime = {HUNG_AT}\n", "constants")
    with changed(name, value):
        *_, last = closed_loop(config, round((HUNG_AT + FOUND_SECONDS) / config.loop.period), {})
    force = WEIGHT * np.array(config.rod.gravity)
    return float(np.linalg.norm(np.array(last.observer.force) - force) / np.linalg.norm(force))


def observer_row(points: Sequence[Point], results: Sequence[PointResult]) -> list[str]:
    """Count what became of the plants."""
    hit = [result for point, result in zip(points, results, strict=True) if point.impact_n]
    errors = [one.force_error_n for one in results if one.force_error_n is not None]
    settling = [one.settling_iterations for one in results if one.settling_iterations is not None]
    return [
        f"{sum(result.meets for result in results)} of {len(results)}",
        f"{sum(result.recovers for result in hit)} of {len(hit)}",
        f"{sum(result.mode != 'tracking' for result in results)}",
        f"{np.median(errors):.4f}",
        f"{np.mean(settling):.1f}",
    ]


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


def own_value(name: str) -> float:
    """Return the value that a constant has."""
    if name in REFERENCE:
        return float(getattr(planar, name))
    (default,) = (field.default for field in fields(ObserverGains) if field.name == name)
    assert isinstance(default, float)
    return default


def values_of(names: Sequence[str], table: dict[str, tuple[float, ...]]) -> list[tuple[str, float]]:
    """List the values to run: one constant's own, then the others of each."""
    listed = [name for name in names if name in table]
    own = [(name, own_value(name)) for name in listed[:1]]
    return own + [(name, value) for name in listed for value in table[name]]


def print_table(columns: Sequence[str], rows: Iterator[list[str]]) -> None:
    """Print a table row by row."""
    print(f"| {' | '.join(columns)} |\n|{' --- |' * len(columns)}")
    for row in rows:
        print(f"| {' | '.join(row)} |", flush=True)
    print()


def main() -> None:
    """Print both tables; the first row of each has the constants' own values."""
    every = {**GAINS, **REFERENCE}
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(every)}; all without one")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    if unknown := set(given.names) - every.keys():
        parser.error(f"unknown: {', '.join(sorted(unknown))}; choose from {', '.join(every)}")
    names = given.names or list(every)
    points = plants()
    with ProcessPoolExecutor(given.processes) as pool:

        def observers() -> Iterator[list[str]]:
            for name, value in values_of(names, GAINS):
                results = list(pool.map(run_plant, [(name, value, point) for point in points]))
                weight = f"{1e2 * weight_error(name, value):.0f}"
                yield [name, f"{value:g}", *observer_row(points, results), weight]

        def references() -> Iterator[list[str]]:
            weights = [
                (f"[reference]\nacross = {across}\n[simulator.weight]\nmass = {grams / 1e3}\ntime = 1.0\n", across)
                for across, grams in WEIGHTS
            ]
            runs = [*weights, (f"[reference]\nacross = 0.34\n{SOFT_AND_PUSHED}", 0.34)]
            for name, value in values_of(names, REFERENCE):
                yield [name, f"{value:g}", *pool.map(run_reference, [(name, value, *one) for one in runs])]

        measures = ("meet the goal", "recover", "faults", "force error N", "settling cycles", "weight error %")
        if values_of(names, GAINS):
            print_table(("constant", "value", *measures), observers())
        cases = [f"{grams} g at {across:g} m" for across, grams in WEIGHTS]
        if values_of(names, REFERENCE):
            print_table(("constant", "value", *cases, "push on a soft arm"), references())


if __name__ == "__main__":
    main()
