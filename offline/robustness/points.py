"""Plants that the closed loop is run on: the axes, and sets of points on them."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

FEEDBACKS = ("force", "offset", "direct")
"""The observer's two kinds, the first the default, and no observer."""

DIRECTIONS = ("+x", "-x", "+z", "-z")
CONFIGURED = ("exact", "delay+1", "delay-1", "lag+0.1", "lag-0.1")
"""Delay [cycles] and lag [-] as configured in the controller, relative to the plant's."""


@dataclass(frozen=True)
class Point:
    """A plant and its controller. The fields are the CSV's first columns; the defaults are the controller's model.

    Attributes:
        part: set of points that it is in.
        law: name of the law. feedback: one of `FEEDBACKS`.
        delay_cycles: age of a pose when it arrives.
        lag_factor: fraction of a step of tension (or displacement) remaining after one cycle [-].
        noise_mm: standard deviation of each measured coordinate of the tip.
        youngs_factor, bending_damping_factor, drag_factor: E, Bbt, C of the plant against the model's [-].
        load_g: mass on the tip, from the start.
        drive: 'tension', ideal; or 'displacement', elastic tendons pulled by servos with a rate limit.
        impact_n: size of a push on the tip, once it has settled; 0: none. impact_direction: one of `DIRECTIONS`.
        impact_ms: duration of the push.
        configured: delay and lag in the controller's configuration, of `CONFIGURED`.
    """

    part: str
    law: str
    feedback: str
    delay_cycles: int = 0
    lag_factor: float = 0.0
    noise_mm: float = 0.0
    youngs_factor: float = 1.0
    bending_damping_factor: float = 1.0
    drag_factor: float = 1.0
    load_g: float = 0.0
    drive: str = "tension"
    impact_n: float = 0.0
    impact_direction: str = "+x"
    impact_ms: float = 0.0
    configured: str = "exact"

    @property
    def key(self) -> str:
        """Key of the point, whatever set it is in: equal keys are the same run."""
        return "/".join(str(getattr(self, field.name)) for field in fields(self) if field.name != "part")

    def __str__(self) -> str:
        """Describe the differences from the nominal point, for people."""
        given = [
            f"{name} {getattr(self, field):g}{unit}"
            for field, (name, unit) in _SHORT.items()
            if getattr(self, field) != getattr(_NOMINAL, field)
        ]
        if self.drive != "tension":
            given.append("servos")
        if self.impact_n:
            given.append(f"impact {self.impact_n:g} N {self.impact_direction} {self.impact_ms:g} ms")
        if self.configured != "exact":
            given.append(f"configured {self.configured}")
        return ", ".join(given) or "nominal"


_NOMINAL = Point("", "", "")
_SHORT = {
    "delay_cycles": ("delay", ""),
    "lag_factor": ("lag", ""),
    "noise_mm": ("noise", " mm"),
    "youngs_factor": ("E x", ""),
    "bending_damping_factor": ("Bbt x", ""),
    "drag_factor": ("C x", ""),
    "load_g": ("load", " g"),
}

AXES: dict[str, tuple[int | float | str, ...]] = {
    "delay_cycles": (0, 1, 2, 3, 4),
    "lag_factor": (0.0, 0.5, 0.8),
    "noise_mm": (0.0, 0.1, 0.3),
    "youngs_factor": (0.85, 1.0, 1.15),
    "bending_damping_factor": (0.5, 1.0, 2.0),
    "drag_factor": (0.5, 1.0, 2.0),
    "load_g": (0.0, 20.0, 50.0),
    "drive": ("tension", "displacement"),
}
"""Every axis but the impacts, in increasing order."""

IMPACTS: tuple[tuple[float, str, float], ...] = tuple(itertools.product((1.0, 3.0, 10.0), DIRECTIONS, (10.0, 50.0)))
"""Size [N], direction, duration [ms]."""

SAMPLE_SIZE = 50
"""Points per law of the seeded sample, by default."""


def nominal_and_axes(law: str, feedback: str) -> list[Point]:
    """Return the nominal point, one axis at a time, and delay and lag together without anything else."""
    start = Point("axes", law, feedback)
    points = [start]
    for name, values in AXES.items():
        points += [_at(start, {name: value}) for value in values]
    points += [_with_impact(start, impact) for impact in IMPACTS]
    points += [
        replace(start, delay_cycles=int(delay), lag_factor=float(lag))
        for delay, lag in itertools.product(AXES["delay_cycles"], AXES["lag_factor"])
    ]
    return points


def misconfigured(law: str, feedback: str) -> list[Point]:
    """Return delays wrong by a cycle, or lags wrong by 0.1, over all delays and lags that allow it."""
    points = []
    for delay, lag, configured in itertools.product((0, 2, 4), (0.0, 0.5, 0.8), CONFIGURED[1:]):
        if (delay == 0 and configured == "delay-1") or (lag == 0.0 and configured == "lag-0.1"):
            continue
        points.append(Point("misconfigured", law, feedback, delay_cycles=delay, lag_factor=lag, configured=configured))
    return points


def corners(law: str, feedback: str) -> list[Point]:
    """Return the extremes of all axes together, with one of the largest impacts each."""
    extremes = {name: (values[0], values[-1]) for name, values in AXES.items()}
    return _factorial("corners", law, feedback, extremes, [one for one in IMPACTS if one[0] == IMPACTS[-1][0]])


def grid(law: str, feedback: str) -> list[Point]:
    """Return the full factorial of all axes, with one impact each."""
    return _factorial("grid", law, feedback, AXES, IMPACTS)


def sample(law: str, feedback: str, count: int, seed: int) -> list[Point]:
    """Random points within the axes' ranges: factors log-uniform, the rest uniform; the same for every law."""
    random = np.random.default_rng([seed, 2])

    def uniform(name: str) -> float:
        return round(float(random.uniform(float(AXES[name][0]), float(AXES[name][-1]))), 3)

    def factor(name: str) -> float:
        ends = np.log([float(AXES[name][0]), float(AXES[name][-1])])
        return round(float(np.exp(random.uniform(*ends))), 3)

    return [
        Point(
            "sample",
            law,
            feedback,
            delay_cycles=int(random.integers(0, int(AXES["delay_cycles"][-1]) + 1)),
            lag_factor=uniform("lag_factor"),
            noise_mm=uniform("noise_mm"),
            youngs_factor=factor("youngs_factor"),
            bending_damping_factor=factor("bending_damping_factor"),
            drag_factor=factor("drag_factor"),
            load_g=uniform("load_g"),
            drive=str(AXES["drive"][int(random.integers(2))]),
            impact_n=round(float(random.uniform(1.0, 10.0)), 2),
            impact_direction=DIRECTIONS[int(random.integers(len(DIRECTIONS)))],
            impact_ms=float(random.integers(1, 6) * 10),
        )
        for _ in range(count)
    ]


POINT_SETS = ("default", "axes", "corners", "grid", "sample")
"""`default`: axes for every feedback, and the rest but the grid for the default observer."""


def points_of(
    name: str,
    laws: Sequence[str],
    feedbacks: Sequence[str] | None = None,
    *,
    count: int = SAMPLE_SIZE,
    seed: int = 0,
    load: float = 1.0,
) -> list[Point]:
    """Return a set of points, without repetition, in an order that depends on the arguments alone.

    Args:
        name: one of `POINT_SETS`.
        laws: laws to run.
        feedbacks: feedbacks to run; none: all of them for the axes, the default observer for the others.
        count: random points per law.
        seed: seed of the random points.
        load: factor on masses and impacts, which are those for the paper's robot [-]; see `unlike.load_factor`.
    """
    default = FEEDBACKS[:1]
    makers: dict[str, tuple[Sequence[str], Callable[[str, str], list[Point]]]] = {
        "axes": (FEEDBACKS, nominal_and_axes),
        "misconfigured": (default, misconfigured),
        "corners": (default, corners),
        "grid": (default, grid),
        "sample": (default, lambda law, feedback: sample(law, feedback, count, seed)),
    }
    wanted = {"default": ("axes", "misconfigured", "corners", "sample"), "axes": ("axes", "misconfigured")}.get(
        name, (name,)
    )
    points = [
        point
        for part in wanted
        for feedback in (makers[part][0] if feedbacks is None else feedbacks)
        for law in laws
        for point in makers[part][1](law, feedback)
    ]
    unique: dict[str, Point] = {}
    for point in points:
        scaled = replace(point, load_g=_rounded(load * point.load_g), impact_n=_rounded(load * point.impact_n))
        unique.setdefault(scaled.key, scaled)
    return list(unique.values())


def _rounded(value: float) -> float:
    """Round to six digits: a product with 1 is the number itself."""
    return float(f"{value:.6g}")


def _factorial(
    part: str,
    law: str,
    feedback: str,
    axes: Mapping[str, tuple[int | float | str, ...]],
    impacts: Sequence[tuple[float, str, float]],
) -> list[Point]:
    """Return every combination with one impact: all impacts equally often, in a fixed random order.

    In a regular order an impact would always meet the same value of some axis.
    """
    start = Point(part, law, feedback)
    combinations = list(itertools.product(*axes.values()))
    order = np.random.default_rng(3).permutation(len(combinations)) % len(impacts)
    return [
        _with_impact(_at(start, dict(zip(axes, values, strict=True))), impacts[which])
        for values, which in zip(combinations, order.tolist(), strict=True)
    ]


def _at(point: Point, place: Mapping[str, Any]) -> Point:
    """Return the point with the values of some axes, by their names."""
    return replace(point, **place)


def _with_impact(point: Point, impact: tuple[float, str, float]) -> Point:
    size, direction, duration = impact
    return replace(point, impact_n=size, impact_direction=direction, impact_ms=duration)
