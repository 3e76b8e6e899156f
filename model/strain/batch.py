"""Many rods at once: independent robots, each with its own parameters, friction, base, loads and state.

Each rod is stepped by the kernel that steps one alone, so the numbers are the same to the last bit. The kernel releases
the GIL; who has threads hands over their `map`.
"""

from collections.abc import Callable, Iterable, Sequence
from typing import Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.numerics.compile import Bound
from tendond.model.strain.describe.base import Base
from tendond.model.strain.robot import Robot
from tendond.model.strain.rod import STEP_TOLERANCE
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.acting import Acting, inputs_of
from tendond.model.strain.stepping.lanes import Lanes, pulls_shape, sizes_of
from tendond.model.strain.stepping.many import Motion, Track, advance_many

Array = NDArray[np.float64]
Run = Callable[[Callable[[int], None], Iterable[int]], Iterable[None]]
"""`map`, or that of a pool of threads."""


class RodBatch:
    """Independent rods, stepped together.

    Args:
        robots: one per rod, N of them, with the same numbers of strain modes and of tendons, otherwise unlike. One that
            is repeated is laid out once; those of one structure share working arrays.
        time_step: of each step [s].
        workers: parts that `step` hands to `run`; each has its own scratch arrays.

    Attributes:
        counts: iterations, steps, and steps that were minima (see `StrainState`), summed up, shape (N, 3).

    Raises:
        ParameterError: robots with other numbers of modes or tendons than the first, or none.
    """

    def __init__(self, robots: Sequence[Robot], time_step: float = 0.01, workers: int = 1) -> None:
        if not robots or workers < 1:
            raise ParameterError("batch: robots is empty, or workers is below 1")
        if not (np.isfinite(time_step) and time_step > 0.0):
            raise ParameterError(f"time_step = {time_step!r} must be finite and above 0")
        self.time_step = time_step
        self._lanes = Lanes(robots)
        layouts, count = self._lanes.layouts, len(robots)
        n, m = sizes_of(layouts[0])
        self._motion = Motion(
            strain=np.zeros((count, n)),
            rate=np.zeros((count, n)),
            counts=np.zeros((count, 3), dtype=np.int64),
            earlier=np.zeros((count, 2, n)),
            begun=np.zeros(count, dtype=np.bool_),
            pulls=self._lanes.pulls(),
            lost=np.zeros(count),
        )
        self.counts = self._motion.counts
        self._base = np.zeros((count, 25))
        self._stiffness = np.array([layout.tendon_stiffness for layout in layouts]).reshape(count, m)
        self._parts = self._lanes.parts(workers)
        self._advance = [Bound(advance_many) for _ in range(workers)]

    def __len__(self) -> int:
        return len(self.strain)

    @property
    def strain(self) -> Array:
        """Strains of the modes, shape (N, n); to be read and written."""
        return self._motion.strain

    @strain.setter
    def strain(self, value: ArrayLike) -> None:
        self._motion.strain[:] = value

    @property
    def rate(self) -> Array:
        """Rates of the strains [1/s], shape (N, n); to be read and written."""
        return self._motion.rate

    @rate.setter
    def rate(self, value: ArrayLike) -> None:
        self._motion.rate[:] = value

    def state(self, index: int) -> StrainState:
        """Return the state of one rod, from which `StrainRod` goes on as the batch does."""
        motion, (rubbing, cells) = self._motion, pulls_shape(self._lanes.layouts[index])
        earlier = motion.earlier[index].copy()
        return StrainState(
            motion.strain[index].copy(),
            motion.rate[index].copy(),
            earlier=(earlier[0], earlier[1]) if motion.begun[index] else None,
            base=Base.from_row(self._base[index]) if self._base[index].any() else None,
            pulls=motion.pulls[index, :rubbing, :cells].copy() if rubbing else None,
            friction_work=float(motion.lost[index]),
        )

    def set_state(self, index: int, state: StrainState) -> None:
        """Let one rod go on from a state of its robot, as one that `StrainRod.solve_static` returns.

        Raises:
            ParameterError: the state is of another robot.
        """
        motion, shape = self._motion, pulls_shape(self._lanes.layouts[index])
        fits = state.pulls is None or state.pulls.shape == shape
        if state.strain.shape != motion.strain[index].shape or not fits:
            raise ParameterError(f"batch: the state for rod {index} is of a robot with other modes or tendon points")
        motion.strain[index], motion.rate[index] = state.strain, state.rate
        motion.begun[index] = state.earlier is not None
        motion.earlier[index] = 0.0 if state.earlier is None else state.earlier
        motion.pulls[index, : shape[0], : shape[1]] = 0.0 if state.pulls is None else state.pulls
        motion.lost[index] = state.friction_work
        self._base[index] = 0.0 if state.base is None else state.base.row()

    def step(self, *, steps: int = 1, run: Run = map, **acting: Unpack[Acting]) -> None:
        """Advance every rod.

        Args:
            steps: time steps to take.
            run: `map`, or that of a pool of threads.
            **acting: tension or displacement, tip_force, base; see `Acting`.

        Raises:
            ParameterError: see `inputs_of`.
            ConvergenceError: a state is not finite.
        """
        self._take(acting, steps, run, 0)

    def follow(self, *, steps: int = 1, run: Run = map, **acting: Unpack[Acting]) -> Track:
        """Advance every rod as `step` does, and return the tips and the tendons' displacements after each step.

        Raises:
            ParameterError, ConvergenceError: see `step`.
        """
        return self._take(acting, steps, run, steps)

    def _take(self, acting: Acting, steps: int, run: Run, kept: int) -> Track:
        inputs, self._base = inputs_of(acting, self._stiffness, self._base, steps, self.time_step)
        track = Track(np.zeros((kept, len(self), 3)), np.zeros((kept, *self._stiffness.shape)))

        def part(worker: int) -> None:
            for room, lanes in self._parts[worker]:
                self._advance[worker].call(
                    self._lanes.layouts[0], room, self._lanes.kinds, inputs, self._motion, track,
                    self.time_step, STEP_TOLERANCE, lanes, steps,
                )  # fmt: skip

        for _ in run(part, range(len(self._parts))):
            pass
        if not (np.all(np.isfinite(self.strain)) and np.all(np.isfinite(self.rate))):
            raise ConvergenceError("batch: a step from a state that is not finite", 0.0, 0.0, 0)
        return track
