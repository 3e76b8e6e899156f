"""The fit's residuals and their derivatives, over several recordings at once."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.parameters import Parameter, bounds
from tendond.offline.identification.simulation.motion import SimulationError, TipMotion
from tendond.offline.identification.simulation.simulate import MOTIONLESS, Simulation

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
    """

    def __init__(
        self,
        simulations: Sequence[Simulation],
        parameters: Sequence[Parameter],
        start: Mapping[str, float],
        load_noise: float | None,
        jobs: int,
        report: Report,
    ) -> None:
        self.simulations = tuple(simulations)
        self.parameters = tuple(parameters)
        self.start = dict(start)
        self._load_noise = load_noise
        self._jobs = jobs
        self._report = report
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
        simulations = [Simulation(one.recording, one.drive, 0.5 * one.step) for one in self.simulations]
        return FitProblem(simulations, self.parameters, self.start, self._load_noise, self._jobs, self._report)

    def shaped(self, row: Array) -> list[list[Array]]:
        """Split the flat residuals into each recording's blocks."""
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
        row = _row(self.blocks(values, motions))
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
            moving.append(any(parameter.name not in MOTIONLESS[s.drive] for s in self.simulations))
        runs = [base, *(values for values, moves in zip(shifted, moving, strict=True) if moves)]
        motions = iter(self._motions(runs, "derivatives"))
        still = next(motions)
        row = _row(self.blocks(base, still))
        columns = [
            (_row(self.blocks(values, next(motions) if moves else still)) - row) / step
            for values, step, moves in zip(shifted, steps, moving, strict=True)
        ]
        return np.column_stack(columns)

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

    def _together(self, runs: int, simulation: Simulation) -> int:
        """Return the number of sets of values that one task simulates: as many as leave each thread a task."""
        return max(1, runs * len(self.simulations) // self._jobs) if simulation.general else 1


def _row(blocks: Sequence[Sequence[Array]]) -> Array:
    return np.concatenate([block.ravel() for recording in blocks for block in recording])
