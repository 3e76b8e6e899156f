"""Many rods at once: independent robots of one structure, each with its own parameters, loads and state.

Each rod is stepped by the kernel that steps one alone, so the numbers are the same to the last bit. The kernel releases
the GIL; who has threads hands over their `map`.
"""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound
from tendond.model.numerics.parked import address_of
from tendond.model.strain.layout import Layout, lay_out
from tendond.model.strain.robot import Robot
from tendond.model.strain.rod import STEP_TOLERANCE
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.many import Inputs, Kinds, Motion, Room, Track, advance_many, measures_of
from tendond.model.strain.stepping.scratch import Loads, mirrored, scratch_for

Array = NDArray[np.float64]
Run = Callable[[Callable[[int], None], Iterable[int]], Iterable[None]]
"""`map`, or that of a pool of threads."""


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
        rubbing = [str(index) for index, robot in enumerate(robots) if any(one.friction > 0.0 for one in robot.tendons)]
        if rubbing:
            raise ParameterError(
                f"batch: robot {rubbing[0]} has a tendon with friction, whose tensions along it a batch does not carry:"
                " set its friction to 0"
            )
        layouts: dict[int, Layout] = {}
        for robot in robots:
            if id(robot) not in layouts:
                layouts[id(robot)] = lay_out(robot)
        first = layouts[id(robots[0])]
        for index, robot in enumerate(robots):
            if not _alike(first, layouts[id(robot)]):
                raise ParameterError(f"batch: robot {index} has not the structure of robot 0")
        numbers = {key: index for index, key in enumerate(layouts)}
        self._robots = tuple(robots)  # the keys are their ids
        self._layouts = layouts
        self._like = first
        count, n, m = len(robots), len(first.component), len(first.straight)
        self._strain, self._rate = np.zeros((count, n)), np.zeros((count, n))
        self._earlier = np.zeros((count, 2, n))
        self.counts = np.zeros((count, 3), dtype=np.int64)
        self._stiffness = np.array([layouts[id(robot)].tendon_stiffness for robot in robots]).reshape(count, m)
        tip = [
            index
            for index in range(len(first.mass))
            if first.place[index] == len(first.polar) - 1 and not first.arm[index].any()
        ]
        self._kinds = Kinds(
            np.array([address_of(layouts[id(robot)]) for robot in robots], dtype=np.int64),
            np.array([numbers[id(robot)] for robot in robots], dtype=np.int64),
            np.array([measures_of(layout) for layout in layouts.values()]),
            np.array(tip[:1], dtype=np.int64),
        )
        self._rooms = []
        for _ in range(workers):
            loads = Loads(
                np.zeros((len(first.mass), 3)),
                np.zeros(m),
                np.zeros(m, dtype=np.bool_),
                np.zeros((len(first.polar), 3)),
            )
            work = scratch_for(first)
            self._rooms.append(Room(work, mirrored(work), loads))
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
        self._take(tension, displacement, tip_force, steps, run, 0)

    def follow(
        self,
        tension: ArrayLike | None = None,
        displacement: ArrayLike | None = None,
        tip_force: ArrayLike = (0.0, 0.0, 0.0),
        steps: int = 1,
        run: Run = map,
    ) -> Track:
        """Advance every rod as `step` does, and return the tips and the tendons' displacements after each step.

        Raises:
            ParameterError, ConvergenceError: see `step`.
        """
        return self._take(tension, displacement, tip_force, steps, run, steps)

    def _take(
        self,
        tension: ArrayLike | None,
        displacement: ArrayLike | None,
        tip_force: ArrayLike,
        steps: int,
        run: Run,
        kept: int,
    ) -> Track:
        if (tension is None) == (displacement is None):
            raise ParameterError("batch: give tension or displacement, one of them")
        name, value = ("displacement", displacement) if tension is None else ("tension", tension)
        given = self._given(name, value, self._stiffness.shape[1], steps)
        if tension is not None and np.any(given < 0.0):
            raise ParameterError("batch: a tendon cannot push: tension must not be negative")
        if tension is None and np.any(self._stiffness <= 0.0):
            raise ParameterError("batch: a tendon without stiffness can only be driven by tension")
        force = self._given("tip_force", tip_force, 3, steps)

        motion = Motion(self._strain, self._rate, self.counts, self._earlier)
        track = Track(np.zeros((kept, len(self), 3)), np.zeros((kept, *self._stiffness.shape)))

        def part(worker: int) -> None:
            self._rooms[worker].loads.driven[:] = tension is None
            rods = int(self._edges[worker]), int(self._edges[worker + 1])
            self._advance[worker].call(
                self._like, self._rooms[worker], self._kinds, Inputs(given, force), motion, track,
                self.time_step, STEP_TOLERANCE, rods, steps,
            )  # fmt: skip

        for _ in run(part, range(len(self._rooms))):
            pass
        if not (np.all(np.isfinite(self.strain)) and np.all(np.isfinite(self.rate))):
            raise ConvergenceError("batch: a step from a state that is not finite", 0.0, 0.0, 0)
        return track

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
