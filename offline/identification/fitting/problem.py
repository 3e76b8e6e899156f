"""The fit's residuals and their derivatives, over several recordings at once."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.parameter import Parameter, bounds
from tendond.offline.identification.priors import Prior
from tendond.offline.identification.simulation.motion import SimulationError, TipMotion
from tendond.offline.identification.simulation.simulated import Simulated

Array = NDArray[np.float64]


Report = Callable[[str, int, int], None]
"""Called with the phase, the simulations done, and their number."""


LOGARITHMIC_STEP = 1e-3


COORDINATE_STEP = 1e-2
"""Steps of the difference quotients: a thousandth of a value; 0.1 ms, 10 um."""


class FitProblem:
    """Residuals and their derivatives, computed by several threads: the rod's kernel does not hold the interpreter.

    Args:
        simulations: one for each recording.
        parameters: parameters to fit.
        start: start values of all parameters, by name.
        load_noise: noise of the servos' tensions [N]; none: they are not used.
        jobs: number of threads.
        report: called with the progress.
        priors: what is known of parameters, by name; of those that are not fitted it is ignored.
        prior_scale: residual [m] that counts as one sigma of a prior: what the poses are off.
    """

    def __init__(
        self,
        simulations: Sequence[Simulated],
        parameters: Sequence[Parameter],
        start: Mapping[str, float],
        load_noise: float | None,
        jobs: int,
        report: Report,
        priors: Mapping[str, Prior] | None = None,
        prior_scale: float = 0.0,
    ) -> None:
        self.simulations = tuple(simulations)
        self.parameters = tuple(parameters)
        self.start = dict(start)
        self._load_noise = load_noise
        self._jobs = jobs
        self._report = report
        self._priors = dict(priors or {})
        self.prior_scale = prior_scale
        self._size = 0  # number of residuals; zero before the first evaluation, which must succeed

    def values(self, coordinates: Array) -> dict[str, float]:
        """Return the values of all parameters by name, from the coordinates of the fitted ones."""
        fitted = {
            parameter.name: parameter.value(float(coordinate), self.start[parameter.name])
            for parameter, coordinate in zip(self.parameters, coordinates, strict=True)
        }
        return {**self.start, **fitted}

    def finer(self) -> "FitProblem":
        """Return the problem with half the time step."""
        simulations = [one.finer() for one in self.simulations]
        return FitProblem(
            simulations, self.parameters, self.start, self._load_noise, self._jobs, self._report, self._priors,
            self.prior_scale,
        )  # fmt: skip

    def shaped(self, row: Array) -> list[list[Array]]:
        """Split the flat residuals into each recording's blocks; those of the priors, at their end, are left out."""
        found, start = [], 0
        for simulation in self.simulations:
            blocks = []
            for rows, width in simulation.shapes(self._load_noise is not None):
                blocks.append(row[start : start + rows * width].reshape(rows, width))
                start += rows * width
            found.append(blocks)
        return found

    def blocks(self, values: Mapping[str, float], motions: Sequence[TipMotion]) -> list[list[Array]]:
        """Compute each recording's residuals."""
        return [
            simulation.residuals(values, motion, self._load_noise)
            for simulation, motion in zip(self.simulations, motions, strict=True)
        ]

    def residuals(self, coordinates: Array) -> Array:
        """Compute all residuals, flat, shape (r,); infinite where the rod has no solution."""
        values = self.values(coordinates)
        try:
            motions = self._motions([values], "trying")[0]
        except SimulationError:
            if self._size == 0:
                raise
            return np.full(self._size, np.inf)
        row = self._row(values, motions)
        self._size = row.size
        return row

    def jacobian(self, coordinates: Array) -> Array:
        """Compute the residuals' derivatives by differences, shape (r, p)."""
        base = self.values(coordinates)
        shifted, steps, moving = [], [], []
        for k, parameter in enumerate(self.parameters):
            step = LOGARITHMIC_STEP if parameter.logarithmic else COORDINATE_STEP
            highest = bounds(parameter, self.start[parameter.name])[1]
            if coordinates[k] + step > highest:
                step = -step
            changed = coordinates.copy()
            changed[k] += step
            steps.append(step)
            shifted.append(self.values(changed))
            moving.append(any(parameter.name not in s.motionless for s in self.simulations))
        runs = [base, *(values for values, moves in zip(shifted, moving, strict=True) if moves)]
        motions = iter(self._motions(runs, "derivatives"))
        still = next(motions)
        row = self._row(base, still)
        columns = [
            (self._row(values, next(motions) if moves else still) - row) / step
            for values, step, moves in zip(shifted, steps, moving, strict=True)
        ]
        return np.column_stack([np.zeros((row.size, 0)), *columns])

    def _motions(self, runs: Sequence[Mapping[str, float]], what: str) -> list[list[TipMotion]]:
        """Compute the tip's motion of each recording for each set of values."""
        tasks = [
            (number, first, runs[first : first + size])
            for number, simulation in enumerate(self.simulations)
            for size in (self._together(len(runs), simulation),)
            for first in range(0, len(runs), size)
        ]
        found: dict[tuple[int, int], TipMotion] = {}
        pool = ThreadPoolExecutor(self._jobs)
        try:
            futures = [pool.submit(self.simulations[number].motions, sets) for number, _, sets in tasks]
            for future, (number, first, _) in zip(futures, tasks, strict=True):
                found |= {(first + index, number): motion for index, motion in enumerate(future.result())}
                self._report(what, len(found), len(runs) * len(self.simulations))
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
        return [[found[row, number] for number in range(len(self.simulations))] for row in range(len(runs))]

    def _together(self, runs: int, simulation: Simulated) -> int:
        """Return the number of sets of values that one task simulates: as many as leave each thread a task."""
        return max(1, runs * len(self.simulations) // self._jobs) if simulation.general else 1

    def _row(self, values: Mapping[str, float], motions: Sequence[TipMotion]) -> Array:
        """Return all residuals, flat: of the recordings, then of the priors of the fitted parameters."""
        known = [(self._priors[one.name], values[one.name]) for one in self.parameters if one.name in self._priors]
        off = [self.prior_scale * (value - prior.value) / prior.sigma for prior, value in known]
        blocks = [block.ravel() for recording in self.blocks(values, motions) for block in recording]
        return np.concatenate([*blocks, np.array(off)])

    def data(self, row: Array) -> Array:
        """Return the flat residuals without those of the priors."""
        return row[: row.size - self.prior_count]

    @property
    def prior_count(self) -> int:
        """Number of priors of fitted parameters, whose residuals come last."""
        return sum(one.name in self._priors for one in self.parameters)
