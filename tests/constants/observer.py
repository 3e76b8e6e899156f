"""The observer's constants on plants of `tendond study robustness`.

Every axis, impacts among them, some corners and some random plants; a row counts the runs that meet the study's goal.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from dataclasses import fields, replace
from typing import Any
from unittest.mock import patch

import numpy as np

from tendond.daemon.control.gains import observer_gains
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.model.estimation.observer_gains import INNOVATION_TIME, ObserverGains
from tendond.model.rod.parameters import RodParameters
from tendond.offline.robustness.evaluate import PointResult, evaluate
from tendond.offline.robustness.points import Point, corners, points_of, sample
from tendond.schemas.config.rig import RigConfig, parse_config
from tests.constants.values import NONE, Neighbours, in_words, print_table, values_of

LAW, FEEDBACK, SEED = "backstepping", "force", 0
CORNER_STEP, SAMPLES = 64, 8

WEIGHT, HUNG_AT, FOUND_SECONDS = 0.05, 1.5, 3.0
"""Mass of the weight [kg], time at which it is hung on, and time in which it is found [s]."""

GAINS: Neighbours = {
    "innovation_limit": (0.03, 0.3, NONE),
    "pull_factor": (1.0, 16.0),
    "unobservable": (0.01, 0.16),
    "lateral_variance": (0.1, 1.0),
    "innovation_time": (0.035, 0.14),
}
"""Fields of `ObserverGains`, and values beside their own."""

COLUMNS = "meet the goal", "recover", "faults", "force error N", "settling cycles", "weight error %"


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


def own_values() -> dict[str, Any]:
    """Return the values that the constants have."""
    defaults = {field.name: field.default for field in fields(ObserverGains)}
    return {name: INNOVATION_TIME if name == "innovation_time" else defaults[name] for name in GAINS}


def print_observer(names: Sequence[str], pool: Executor) -> None:
    """Print the table of the constants among `names`."""
    points = plants()

    def rows() -> Iterator[list[str]]:
        for name, value in values_of(names, own_values(), GAINS):
            results = list(pool.map(run_plant, [(name, value, point) for point in points]))
            yield [name, in_words(value), *observer_row(points, results), f"{1e2 * weight_error(name, value):.0f}"]

    print_table(("constant", "value", *COLUMNS), rows())
