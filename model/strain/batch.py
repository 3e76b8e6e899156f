"""Many rods at once: independent robots of one structure, each with its own parameters, loads and state.

Each rod is stepped by the kernel that steps one alone, so the numbers are the same to the last bit. The kernel releases
the GIL; who has threads hands over their `map`.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound, kernel, lean
from tendond.model.numerics.parked import address_of, parked_at
from tendond.model.strain.layout import Layout, lay_out
from tendond.model.strain.robot import Robot
from tendond.model.strain.rod import STEP_TOLERANCE, StrainState
from tendond.model.strain.stepping.advance import advance
from tendond.model.strain.stepping.scratch import Loads, Scratch, mirrored, scratch_for

Array = NDArray[np.float64]
Run = Callable[[Callable[[int], None], Iterable[int]], Iterable[None]]
"""`map`, or that of a pool of threads."""


@lean
def take_measures(work: Scratch, row: Any) -> None:
    """Write a robot's parameters into arrays that those of other robots were in; see `_measures`."""
    at = len(work.scale)
    for a in range(at):
        work.scale[a] = row[a]
    work.unit[0] = row[at]
    at += 1
    weights, routes, modes = (
        len(work.before.directions.weights),
        len(work.paths_before.routes),
        len(work.paths_before.modes),
    )
    for a in range(weights):
        work.before.directions.weights[a] = work.after.directions.weights[a] = row[at + a]
    at += weights
    for a in range(routes):
        work.paths_before.routes[a] = work.paths_after.routes[a] = row[at + a]
    at += routes
    for a in range(modes):
        work.paths_before.modes[a] = work.paths_after.modes[a] = row[at + a]


@kernel
def advance_many(
    like: Layout,
    work: Scratch,
    other: Scratch,
    loads: Any,
    tip: int,
    addresses: Any,
    measures: Any,
    of: Any,
    actuation: Any,
    tip_force: Any,
    strain: Any,
    rate: Any,
    h: float,
    tolerance: float,
    first: int,
    last: int,
    steps: int,
    counts: Any,
) -> None:
    """Advance the rods `first` to `last` by some steps, in place; see `RodBatch`."""
    held = -1
    for i in range(first, last):
        layout = parked_at(like, addresses[i])
        if of[i] != held:
            held = of[i]
            take_measures(work, measures[held])
        for k in range(steps):
            now, pushed = min(k, len(actuation) - 1), min(k, len(tip_force) - 1)
            for a in range(len(loads.tension)):
                loads.tension[a] = actuation[now, i, a]
            for c in range(3):
                loads.force[tip, c] = tip_force[pushed, i, c]
            total, parts, damped = advance(layout, loads, strain[i], rate[i], h, tolerance, work, k > 0)
            work, other = other, work
            counts[i, 0] += total
            counts[i, 1] += parts
            counts[i, 2] += damped


class RodBatch:
    """Independent rods, stepped together.

    Args:
        robots: one per rod, N of them, of one structure: the same numbers of sections, modes and tendons, bodies and
            ends of tendons at nodes of the same numbers. One that is repeated is laid out once.
        time_step: of each step [s].
        workers: parts that `step` hands to `run`; each has its own scratch arrays.

    Attributes:
        counts: iterations, steps, and steps that were minima (see `StrainState`), summed up, shape (N, 3).

    Raises:
        ParameterError: robots of different structure, or none.
    """

    def __init__(self, robots: Sequence[Robot], time_step: float = 0.01, workers: int = 1) -> None:
        if not robots or workers < 1:
            raise ParameterError("batch: robots is empty, or workers is below 1")
        if not (np.isfinite(time_step) and time_step > 0.0):
            raise ParameterError(f"time_step = {time_step!r} must be finite and above 0")
        self.time_step = time_step
        layouts: dict[int, Layout] = {}
        for robot in robots:
            if id(robot) not in layouts:
                layouts[id(robot)] = lay_out(robot)
        first = layouts[id(robots[0])]
        for index, robot in enumerate(robots):
            if not _alike(first, layouts[id(robot)]):
                raise ParameterError(f"batch: robot {index} has not the structure of robot 0")
        numbers = {key: index for index, key in enumerate(layouts)}
        self._of = np.array([numbers[id(robot)] for robot in robots], dtype=np.int64)
        self._measures = np.array([_measures(layout) for layout in layouts.values()])
        self._robots = tuple(robots)  # the keys are their ids
        self._layouts = layouts
        self._addresses = np.array([address_of(layouts[id(robot)]) for robot in robots], dtype=np.int64)
        self._like = first
        count, n, m = len(robots), len(first.component), len(first.straight)
        self._strain, self._rate = np.zeros((count, n)), np.zeros((count, n))
        self.counts = np.zeros((count, 3), dtype=np.int64)
        self._stiffness = np.array([layouts[id(robot)].tendon_stiffness for robot in robots]).reshape(count, m)
        tip = [
            index
            for index in range(len(first.mass))
            if first.place[index] == len(first.polar) - 1 and not first.arm[index].any()
        ]
        self._tip = tip[0]
        self._rooms = []
        for _ in range(workers):
            loads = Loads(
                np.zeros((len(first.mass), 3)),
                np.zeros(m),
                np.zeros(m, dtype=np.bool_),
                np.zeros((len(first.polar), 3)),
            )
            work = scratch_for(first)
            self._rooms.append((work, mirrored(work), loads))
        self._edges = np.linspace(0, count, workers + 1).astype(np.int64)
        self._advance = [Bound(advance_many) for _ in range(workers)]

    def __len__(self) -> int:
        return len(self.strain)

    @property
    def strain(self) -> Array:
        """Strains of the modes, shape (N, n); to be read and written."""
        return self._strain

    @strain.setter
    def strain(self, value: ArrayLike) -> None:
        self._strain[:] = value

    @property
    def rate(self) -> Array:
        """Rates of the strains [1/s], shape (N, n); to be read and written."""
        return self._rate

    @rate.setter
    def rate(self, value: ArrayLike) -> None:
        self._rate[:] = value

    def state(self, index: int) -> StrainState:
        """Return the state of one rod."""
        return StrainState(self.strain[index].copy(), self.rate[index].copy())

    def step(
        self,
        tension: ArrayLike | None = None,
        displacement: ArrayLike | None = None,
        tip_force: ArrayLike = (0.0, 0.0, 0.0),
        steps: int = 1,
        run: Run = map,
    ) -> None:
        """Advance every rod.

        Args:
            tension: of the tendons [N], shape (m,), (N, m), or (steps, N, m); displacement: commands [m] instead.
            tip_force: dead, world frame [N], shape (3,), (N, 3), or (steps, N, 3).
            steps: time steps to take.
            run: `map`, or that of a pool of threads.

        Raises:
            ParameterError: not finite, of another shape, a negative tension, both or neither of tension and
                displacement, or a displacement of a tendon without stiffness.
            ConvergenceError: a state is not finite.
        """
        if (tension is None) == (displacement is None):
            raise ParameterError("batch: give tension or displacement, one of them")
        name, value = ("displacement", displacement) if tension is None else ("tension", tension)
        given = self._given(name, value, self._stiffness.shape[1], steps)
        if tension is not None and np.any(given < 0.0):
            raise ParameterError("batch: a tendon cannot push: tension must not be negative")
        if tension is None and np.any(self._stiffness <= 0.0):
            raise ParameterError("batch: a tendon without stiffness can only be driven by tension")
        force = self._given("tip_force", tip_force, 3, steps)

        def part(worker: int) -> None:
            work, other, loads = self._rooms[worker]
            loads.driven[:] = tension is None
            first, last = int(self._edges[worker]), int(self._edges[worker + 1])
            self._advance[worker].call(
                self._like, work, other, loads, self._tip, self._addresses, self._measures, self._of, given, force,
                self.strain, self.rate, self.time_step, STEP_TOLERANCE, first, last, steps, self.counts,
            )  # fmt: skip

        for _ in run(part, range(len(self._rooms))):
            pass
        if not (np.all(np.isfinite(self.strain)) and np.all(np.isfinite(self.rate))):
            raise ConvergenceError("batch: a step from a state that is not finite", 0.0, 0.0, 0)

    def _given(self, name: str, value: ArrayLike | None, width: int, steps: int) -> Array:
        """Return numbers per step and rod, shape (1 or steps, N, width)."""
        found = np.asarray(value, dtype=np.float64)
        shape = (steps if found.ndim == 3 else 1, len(self), width)
        try:
            found = np.array(np.broadcast_to(found, shape), order="C")  # a copy: never read-only
        except ValueError:
            raise ParameterError(
                f"batch: {name} has shape {np.shape(found)}: it must be one of ({width},), ({len(self)}, {width}), "
                f"({steps}, {len(self)}, {width})"
            ) from None
        if not np.all(np.isfinite(found)):
            raise ParameterError(f"batch: {name} is not finite")
        return found


def _alike(one: Layout, other: Layout) -> bool:
    """Return true if two robots have the same structure, so that they can share scratch arrays."""
    sizes = all(np.shape(a) == np.shape(b) for a, b in zip(one, other, strict=True))
    return sizes and all(
        np.array_equal(a, b)
        for a, b in (
            (one.component, other.component), (one.order, other.order), (one.first, other.first),
            (one.last, other.last), (one.place, other.place), (one.tendon_at != 0.0, other.tendon_at != 0.0),
        )
    )  # fmt: skip


def _measures(layout: Layout) -> Array:
    """Parameters that scratch arrays hold, in a row: measures of strains and of energy, modes and routes at points."""
    work = scratch_for(layout)
    paths = work.paths_before
    return np.concatenate((work.scale, work.unit[:1], work.before.directions.weights, paths.routes, paths.modes))
