"""The fit: nonlinear least squares on the differences of model and measurement, over several recordings at once."""

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tendond.daemon.errors import DaemonError
from tendond.offline.identification.parameters import Parameter, bounds
from tendond.offline.identification.simulate import MOTIONLESS, Simulation, SimulationError, TipMotion

Array = NDArray[np.float64]
Report = Callable[[str, int, int], None]
"""Called with what is being computed, the simulations done, and their number."""

LOGARITHMIC_STEP = 1e-3
COORDINATE_STEP = 1e-2
"""Of the differences that derivatives are taken from: a thousandth of a value, 0.1 ms, 10 um."""

TOLERANCE = 1e-6
"""Of the coordinates and of the sum of squares, relative."""

MAX_EVALUATIONS = 40

FINER_ROUNDS = 2
"""Of the fit with half the time step, by the whole step's derivatives: what the step itself was found as goes."""

REMAINING = 1.0 / 3.0
"""Of a coordinate's change on halving the step: what a scheme of second order is still off (Richardson)."""

Loss = Literal["linear", "soft_l1", "huber"]
LOSSES = get_args(Loss)
OUTLIER = 3.0
"""Residual, in standard deviations, from which on a robust loss counts less."""


class FitError(DaemonError):
    """A fit that came to no result."""


@dataclass(frozen=True)
class FitResult:
    """What a fit found.

    Attributes:
        parameters: that were fitted.
        values: of all parameters, by name.
        coordinates: of the fitted ones, shape (p,).
        residuals: each recording's blocks, see `Simulation.residuals`, in metres.
        jacobian: of all of them in a row against the coordinates, shape (r, p).
        weights: of each residual by the loss, shape (r,); ones where it is linear.
        remaining: what the time step may still be found as, of each coordinate, shape (p,).
        evaluations: of the residuals.
        bounded: names of parameters that ended at a bound.
    """

    parameters: tuple[Parameter, ...]
    values: dict[str, float]
    coordinates: Array
    residuals: list[list[Array]]
    jacobian: Array
    weights: Array
    remaining: Array
    evaluations: int
    bounded: tuple[str, ...]


class Memory:
    """Results of evaluations on disk, so that a fit that was interrupted goes through the same ones at once.

    Args:
        folder: of the files; none: nothing is kept.
        settings: of the fit; results of others are left aside.
    """

    def __init__(self, folder: Path | None, settings: Mapping[str, object]) -> None:
        digest = hashlib.sha256(json.dumps(settings, sort_keys=True, default=str).encode()).hexdigest()[:16]
        self._folder = None if folder is None else folder / digest
        self.known = 0

    def get(self, kind: str, at: Array, make: Callable[[], Array]) -> Array:
        """An evaluation's result: from the folder, or made and kept."""
        if self._folder is None:
            return make()
        path = self._folder / f"{kind}-{hashlib.sha256(at.tobytes()).hexdigest()[:24]}.npy"
        try:
            found = np.load(path, allow_pickle=False)
        except (OSError, ValueError):
            found = make()
            self._folder.mkdir(parents=True, exist_ok=True)
            draft = path.with_suffix(".part")
            with draft.open("wb") as stream:
                np.save(stream, found)
            os.replace(draft, path)
        else:
            self.known += 1
        return np.asarray(found)

    def forget(self) -> None:
        """Remove them: the fit has its result."""
        if self._folder is not None and self._folder.is_dir():
            for file in self._folder.iterdir():
                file.unlink()
            self._folder.rmdir()
            with suppress(OSError):  # other fits' results
                self._folder.parent.rmdir()


class FitProblem:
    """Residuals and their derivatives, computed by several threads: the rod's kernel does not hold the interpreter.

    Args:
        simulations: one for each recording.
        parameters: to fit.
        start: values of all parameters, by name.
        load_noise: of the servos' tensions [N]; none: they are not used.
        jobs: threads.
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
        self._size = 0  # of the residuals; zero before the first, which must have a solution

    def values(self, coordinates: Array) -> dict[str, float]:
        """Of all parameters, by name, at coordinates of the fitted ones."""
        fitted = {
            parameter.name: parameter.value(float(coordinate), self.start[parameter.name])
            for parameter, coordinate in zip(self.parameters, coordinates, strict=True)
        }
        return {**self.start, **fitted}

    def finer(self) -> "FitProblem":
        """The same with half the time step."""
        simulations = [Simulation(one.recording, one.drive, 0.5 * one.step) for one in self.simulations]
        return FitProblem(simulations, self.parameters, self.start, self._load_noise, self._jobs, self._report)

    def shaped(self, row: Array) -> list[list[Array]]:
        """All residuals in a row as each recording's blocks."""
        found, start = [], 0
        for simulation in self.simulations:
            blocks = []
            for rows, width in simulation.shapes(self._load_noise is not None):
                blocks.append(row[start : start + rows * width].reshape(rows, width))
                start += rows * width
            found.append(blocks)
        return found

    def blocks(self, values: Mapping[str, float], motions: Sequence[TipMotion]) -> list[list[Array]]:
        """Each recording's residuals."""
        return [
            simulation.residuals(values, motion, self._load_noise)
            for simulation, motion in zip(self.simulations, motions, strict=True)
        ]

    def residuals(self, coordinates: Array) -> Array:
        """All in a row; not finite where the rod has no solution."""
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
        """By differences, shape (r, p)."""
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
        """Of each recording for each set of values."""
        tasks = [(simulation, values) for values in runs for simulation in self.simulations]
        found: list[TipMotion] = []
        pool = ThreadPoolExecutor(self._jobs)
        try:
            futures = [pool.submit(simulation.motion, values) for simulation, values in tasks]
            for future in futures:
                found.append(future.result())
                self._report(what, len(found), len(tasks))
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
        n = len(self.simulations)
        return [found[i : i + n] for i in range(0, len(found), n)]


def _row(blocks: Sequence[Sequence[Array]]) -> Array:
    return np.concatenate([block.ravel() for recording in blocks for block in recording])


def fit(
    problem: FitProblem, memory: Memory, loss: Loss = "linear", noise: float = 1e-4, first: Array | None = None
) -> FitResult:
    """Least squares over the problem's parameters.

    Args:
        problem: what to fit.
        memory: of evaluations.
        loss: of `LOSSES`.
        noise: of the poses [m], which a robust loss goes by.
        first: coordinates to start from, shape (p,); none: the problem's start.

    Raises:
        SimulationError: the rod has no solution at the start.
        FitError: no result.
    """
    span = np.array([bounds(parameter, problem.start[parameter.name]) for parameter in problem.parameters])

    def residuals(at: Array) -> Array:
        return memory.get("residuals", at, partial(problem.residuals, at))

    def jacobian_at(at: Array) -> Array:
        return memory.get("jacobian", at, partial(problem.jacobian, at))

    found = least_squares(
        residuals,
        np.zeros(len(problem.parameters)) if first is None else np.clip(first, span[:, 0], span[:, 1]),
        jac=jacobian_at,
        bounds=(span[:, 0] - 1e-9, span[:, 1] + 1e-9),
        loss=loss,
        f_scale=OUTLIER * noise,
        x_scale="jac",
        xtol=TOLERANCE,
        ftol=TOLERANCE,
        gtol=None,
        max_nfev=MAX_EVALUATIONS,
    )
    if not np.all(np.isfinite(found.x)) or found.status <= 0:
        raise FitError(f"the fit did not converge in {found.nfev} evaluations: {found.message}")
    return refine(problem.finer(), found.x, jacobian_at(found.x), memory, loss, noise, int(found.nfev))


def refine(
    fine: FitProblem, at: Array, jacobian: Array, memory: Memory, loss: Loss, noise: float, evaluations: int = 0
) -> FitResult:
    """Gauss-Newton with half the time step and the whole step's derivatives, from a fit with the whole step.

    Raises:
        FitError: it does not stay where the rod has a solution.
    """
    span = np.array([bounds(parameter, fine.start[parameter.name]) for parameter in fine.parameters])
    whole, row = at, memory.get("fine", at, partial(fine.residuals, at))
    for _ in range(FINER_ROUNDS):
        root = np.sqrt(loss_weights(loss, row, OUTLIER * noise))
        at = at + bounded_step(root[:, None] * jacobian, root * row, span[:, 0] - at, span[:, 1] - at)
        row = memory.get("fine", at, partial(fine.residuals, at))
        if not np.all(np.isfinite(row)):
            raise FitError("the fit did not stay where the rod has a solution when its time step was halved")
    return FitResult(
        parameters=fine.parameters,
        values=fine.values(at),
        coordinates=at,
        residuals=fine.shaped(row),
        jacobian=jacobian,
        weights=loss_weights(loss, row, OUTLIER * noise),
        remaining=REMAINING * (at - whole),
        evaluations=evaluations,
        bounded=tuple(
            parameter.name
            for parameter, place, (low, high) in zip(fine.parameters, at, span, strict=True)
            if min(place - low, high - place) < 1e-3
        ),
    )


def bounded_step(jacobian: Array, residuals: Array, low: Array, high: Array) -> Array:
    """Gauss-Newton step within bounds, shape (p,): what stops at a bound leaves the others a step of their own.

    Args:
        jacobian: shape (r, p). residuals: shape (r,). low, high: of the step, shape (p,); low <= 0 <= high.
    """
    step, free = np.zeros(len(low)), np.ones(len(low), dtype=bool)
    while np.any(free):
        missing = residuals + jacobian[:, ~free] @ step[~free]
        step[free] = np.linalg.lstsq(jacobian[:, free], -missing, rcond=1e-8)[0]
        beyond = free & ((step < low) | (step > high))
        if not np.any(beyond):
            break
        step[beyond] = np.clip(step, low, high)[beyond]
        free &= ~beyond
    return step


def servo_start(
    simulations: Sequence[Simulation], parameters: Sequence[Parameter], start: Mapping[str, float]
) -> Array:
    """Coordinates for a fit to start from, shape (p,): lag and backlash from the servos' reports alone.

    What a servo makes of its commands needs no rod, and the backlash, which has kinks, no guess far away.
    """
    at = np.zeros(len(parameters))
    rows = [k for k, parameter in enumerate(parameters) if parameter.name in ("lag", "backlash")]
    if not rows or any(simulation.drive != "measured" for simulation in simulations):
        return at

    def apart(coordinates: Array) -> Array:
        values = dict(start)
        for k, coordinate in zip(rows, coordinates, strict=True):
            values[parameters[k].name] = parameters[k].value(float(coordinate), start[parameters[k].name])
        return np.concatenate([simulation.servos_apart(values).ravel() for simulation in simulations])

    span = np.array([bounds(parameters[k], start[parameters[k].name]) for k in rows])
    best: tuple[float, Array] | None = None
    for guess in (0.0, 1.0, 4.0):  # [10 ms] and [0.1 mm] beyond the start, as far as each has room
        first = np.clip(guess, span[:, 0] + 1e-3, span[:, 1] - 1e-3)
        if not apart(first).size:
            return at
        found = least_squares(
            apart, first, bounds=(span[:, 0], span[:, 1]), diff_step=np.full(len(rows), 1e-3), x_scale=1.0
        )
        if best is None or found.cost < best[0]:
            best = float(found.cost), found.x
    assert best is not None
    at[rows] = best[1]
    return at


def loss_weights(loss: str, residuals: Array, scale: float) -> Array:
    """Weight of each residual in the normal equations: the loss' derivative at (r / scale)^2."""
    z = (residuals / scale) ** 2
    if loss == "soft_l1":
        return np.asarray(1.0 / np.sqrt(1.0 + z))
    if loss == "huber":
        return np.asarray(np.where(z <= 1.0, 1.0, 1.0 / np.sqrt(np.maximum(z, 1.0))))
    return np.ones_like(residuals)
