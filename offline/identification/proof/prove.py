"""Identification of the proof's rigs, and how honest its standard errors are."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tendond.offline.identification.configured import nominal
from tendond.offline.identification.fitting.evaluations import EvaluationCache
from tendond.offline.identification.fitting.problem import FitProblem
from tendond.offline.identification.fitting.solve import refine
from tendond.offline.identification.fitting.statistics import statistics
from tendond.offline.identification.identify import identify
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameters import DEFAULT, chosen
from tendond.offline.identification.proof.rigs import USED, ProofTask, record, truth
from tendond.offline.identification.recordings.load import load_recording
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.results.result import Identification
from tendond.offline.identification.simulation.simulate import Simulation
from tendond.schemas.assumed_rig import POSE_NOISE

Array = NDArray[np.float64]


GOALS = {"E": 0.02, "rho": 0.03, "Bbt": 0.10, "C": 0.20, "tip_mass": 0.0009, "delay": 0.002}
"""Maximum errors of the values: those of `ABSOLUTE` in their units, the others relative."""


ABSOLUTE = ("tip_mass", "delay")
"""Parameters that may be zero: their goals are 3 % of 30 g, and seconds."""


@dataclass(frozen=True)
class ProofOutcome:
    """Result of an identification, small enough to pass between processes.

    Attributes:
        task: the task.
        values, errors: the identified parameters by name, and their standard errors.
        missing: parameters that were not identified.
        seconds: length of the logs that were fitted to.
        held_out: distance of model and tip on the log held out, root mean square [m]: configuration's, identified.
    """

    task: ProofTask
    values: dict[str, float]
    errors: dict[str, float]
    missing: tuple[str, ...]
    seconds: float
    held_out: tuple[float, float] | None = None


def identify_logs(paths: Mapping[str, Path], jobs: int) -> Identification:
    """Identify a rig from its logs."""
    recordings = {name: load_recording(path, {}) for name, path in paths.items()}
    used = [recordings[name] for name in USED]
    held = [recordings["held-out"]] if "held-out" in recordings else []
    return identify(used, held, Options(DEFAULT, jobs=jobs))


def prove(task: ProofTask) -> tuple[ProofOutcome, Identification]:
    """Record a rig's logs and identify it, in this process."""
    result = identify_logs(record(task), jobs=1)
    held = [recorded for recorded in result.held_out if not recorded.used]
    return ProofOutcome(
        task=task,
        values=result.values,
        errors={found.parameter.name: found.error for found in result.parameters if found.found},
        missing=tuple(found.parameter.name for found in result.parameters if not found.found),
        seconds=sum(simulation.recording.duration for simulation in result.simulations),
        held_out=(held[0].nominal_rms, held[0].fitted_rms) if held else None,
    ), result


def redraw(task: ProofTask) -> ProofOutcome:
    """Identify a rig again from logs without noise, with the noise of the task's seed added to the poses.

    The derivatives are those at the truth, computed once, and the fit starts there: the question is how it scatters.
    """
    recordings, problem, jacobian = _at_truth(task.plant, task.folder)
    random = np.random.default_rng([task.seed, 7])
    simulations = []
    for recording in recordings:
        position = recording.position + POSE_NOISE * random.standard_normal(recording.position.shape)
        simulations.append(Simulation(replace(recording, position=position, noise=POSE_NOISE), "measured"))
    noisy = FitProblem(simulations, problem.parameters, problem.start, None, 1, lambda what, done, total: None)
    nothing = EvaluationCache(None, {})
    whole = refine(noisy, np.zeros(len(noisy.parameters)), jacobian, nothing, "linear", POSE_NOISE).coordinates
    result = refine(noisy.finer(), whole, jacobian, nothing, "linear", POSE_NOISE)
    deviations = statistics(result).deviations
    return ProofOutcome(
        task=task,
        values={parameter.name: result.values[parameter.name] for parameter in result.parameters},
        errors={
            parameter.name: parameter.error(result.values[parameter.name], float(deviation))
            for parameter, deviation in zip(result.parameters, deviations, strict=True)
        },
        missing=(),
        seconds=sum(recording.duration for recording in recordings),
    )


@functools.lru_cache(maxsize=1)
def _at_truth(plant: str, folder: str) -> tuple[list[Recording], FitProblem, Array]:
    """Load the logs without noise; return the problem, and its derivatives at the truth."""
    recordings = [load_recording(Path(folder) / f"{name}.mcap", {}) for name in USED]
    simulations = [Simulation(recording, "measured") for recording in recordings]
    problem = FitProblem(
        simulations,
        chosen(DEFAULT),
        nominal(recordings[0].config) | truth(plant),
        None,
        1,
        lambda what, done, total: None,
    )
    return recordings, problem, problem.jacobian(np.zeros(len(problem.parameters)))


def met(outcome: ProofOutcome) -> dict[str, bool]:
    """Compare an outcome with the goals, by parameter."""
    true = truth(outcome.task.plant)
    return {
        name: name in outcome.values
        and abs(outcome.values[name] - true[name]) <= goal * (1.0 if name in ABSOLUTE else true[name])
        for name, goal in GOALS.items()
    }


def coverage(outcomes: list[ProofOutcome]) -> dict[str, dict[str, float]]:
    """Compare errors and standard errors over many seeds, by parameter.

    `within_two` is the fraction of fits with the truth within two standard errors, `spread` the root mean
    square of (value - truth) / standard error: one, where the errors are right; `bias` is the mean of the same. Lag and
    backlash are left out: the simulated servos' reports have no noise, so these two are the same in every fit.
    """
    found: dict[str, dict[str, float]] = {}
    everything: list[float] = []
    for name in DEFAULT:
        if name in ("lag", "backlash"):
            continue
        scaled = [
            (outcome.values[name] - truth(outcome.task.plant)[name]) / outcome.errors[name]
            for outcome in outcomes
            if name in outcome.values
        ]
        if scaled:
            found[name] = _honesty(scaled)
            everything += scaled
    found["all"] = _honesty(everything)
    return found


def _honesty(scaled: list[float]) -> dict[str, float]:
    count = len(scaled)
    return {
        "fits": count,
        "within_two": sum(abs(value) <= 2.0 for value in scaled) / count,
        "spread": (sum(value**2 for value in scaled) / count) ** 0.5,
        "bias": sum(scaled) / count,
    }
