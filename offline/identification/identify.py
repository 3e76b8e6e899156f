"""Identification from logs: check, fit, drop what the data do not identify, fit again, compare on other logs."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from tendond.offline.identification.configured import absent, nominal, parameters_of, starts
from tendond.offline.identification.fitting.evaluations import EvaluationCache
from tendond.offline.identification.fitting.problem import FitProblem, Report
from tendond.offline.identification.fitting.servo_start import servo_start
from tendond.offline.identification.fitting.solve import FitResult, fit
from tendond.offline.identification.fitting.statistics import ALIKE, Statistics, statistics
from tendond.offline.identification.force_scale import force_scale, weight_hides_tip_mass
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameters import Parameter, chosen
from tendond.offline.identification.recordings.checks import Finding, check, errors
from tendond.offline.identification.recordings.recording import DataError, Recording
from tendond.offline.identification.results.result import Found, HeldOut, Identification, Ratio
from tendond.offline.identification.simulation.simulate import Simulation
from tendond.offline.source_hash import source_hash

SOURCES = ("model", "schemas", "offline/identification")
"""Modules of the package that a fit's evaluations depend on."""


def identify(
    recordings: Sequence[Recording],
    held_out: Sequence[Recording],
    options: Options,
    report: Report = lambda what, done, total: None,
    memory: Path | None = None,
    tell: Callable[[Finding], None] = lambda finding: None,
) -> Identification:
    """Identify a rig's parameters.

    Args:
        recordings: recordings to fit to; one or more.
        held_out: recordings to compare on.
        options: options of the fit.
        report: called with the progress.
        memory: folder for the evaluations, to resume an interrupted fit; none: nothing is kept.
        tell: called with findings about the logs, before the fit.

    Raises:
        DataError: logs that cannot be fitted to.
        UsageError: parameters that cannot be fitted.
        FitError, SimulationError: no result.
    """
    config = recordings[0].config
    parameters = parameters_of(config.rod, chosen(options.parameters))
    drive = options.drive or ("measured" if all(r.has_reports for r in recordings) else "command")
    everything = [*recordings, *held_out]
    findings = check(everything, drive)
    for finding in findings:
        tell(finding)
    bad = errors(findings)
    if bad:
        raise DataError("\n".join(finding.text for finding in bad))
    why = absent(config, parameters)
    free = [parameter for parameter in parameters if parameter.name not in why]
    starts(config, free)  # refused before anything is computed
    scale, known = force_scale(recordings, free, options)
    simulations = tuple(Simulation(recording, drive) for recording in recordings)
    noise = float(np.median([recording.noise for recording in recordings])) or 1e-5
    kept = EvaluationCache(memory, {
        "logs": [_digest(recording) for recording in recordings], "options": asdict(options) | {"jobs": 0},
        "source": source_hash(SOURCES), "drive": drive,
    })  # fmt: skip
    if known and weight_hides_tip_mass(recordings, parameters, options):
        why["tip_mass"] = "the same weight hangs in every log, so only the sum is identifiable: add a log without it"
        free = [parameter for parameter in free if parameter.name != "tip_mass"]
        scale += f", in addition to rod.tip_mass = {nominal(config)['tip_mass']:g} kg, which these logs cannot check"
    if not known:
        free = [parameter for parameter in free if parameter.name != "E"]
    first: Statistics | None = None
    while True:
        if not free:
            raise DataError("the logs identify none of the parameters: " + "; ".join(why.values()))
        start = starts(config, free)
        problem = FitProblem(simulations, free, start, options.load_noise, options.jobs, report)
        result = fit(problem, kept, options.loss, noise, servo_start(simulations, free, start))
        spread = statistics(result)
        first = first or spread
        lost = _lost(result, spread)
        if not lost:
            break
        why |= lost
        free = [parameter for parameter in free if parameter.name not in lost]
    kept.forget()
    others = tuple(Simulation(recording, drive) for recording in held_out)
    nominal_values = nominal(config)
    return Identification(
        config=config,
        drive=drive,
        findings=tuple(findings),
        parameters=tuple(_found(parameters, nominal_values, result, spread, why, known)),
        ratios=() if known else tuple(_ratios(nominal_values, result, spread)),
        scale=scale,
        fit=result,
        statistics=spread,
        held_out=tuple(
            _compare(simulation, used, nominal_values, result.values)
            for group, used in ((simulations, True), (others, False))
            for simulation in group
        ),
        noise=noise,
        rms=float(np.sqrt(np.mean(np.concatenate([blocks[0].ravel() for blocks in result.residuals]) ** 2))),
        simulations=simulations,
        others=others,
        first=first,
    )


def _digest(recording: Recording) -> str:
    """Hash all that a fit uses of a recording."""
    digest = hashlib.sha256(recording.config.model_dump_json().encode())
    for array in (recording.times, recording.command, recording.reported, recording.pose_times, recording.position):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(repr(recording.weight).encode())
    return digest.hexdigest()


def _lost(result: FitResult, spread: Statistics) -> dict[str, str]:
    """Return the parameters that are not identifiable, with the reasons."""
    names = [parameter.name for parameter in result.parameters]
    lost: dict[str, str] = {}
    for k, parameter in enumerate(result.parameters):
        deviation = spread.deviations[k]
        if parameter.name in result.bounded and not _is_none(parameter, result):
            lost[parameter.name] = (
                f"it reached the end of its range, {result.values[parameter.name]:.4g} {parameter.unit}"
            )
        elif not deviation <= parameter.max_deviation:
            alike = [names[i] for i in range(len(names)) if i != k and abs(spread.correlation[k, i]) > ALIKE]
            together = [name for direction in spread.unidentifiable if parameter.name in direction.names
                        for name in direction.names if name != parameter.name]  # fmt: skip
            partners = list(dict.fromkeys(alike + together))
            if partners:
                lost[parameter.name] = f"these data do not distinguish it from {', '.join(partners)}"
            else:
                lost[parameter.name] = "these data hardly depend on it"
    return lost


def _is_none(parameter: Parameter, result: FitResult) -> bool:
    """Check for a delay, lag, backlash or tip mass of zero, which is a valid result."""
    return parameter.lower < 1e-3 and not parameter.logarithmic and result.values[parameter.name] < 1e-3


def _found(
    parameters: Sequence[Parameter], start: Mapping[str, float], result: FitResult, spread: Statistics,
    why: Mapping[str, str], known: bool,
) -> list[Found]:  # fmt: skip
    """Collect the requested parameters."""
    names = [parameter.name for parameter in result.parameters]
    found = []
    for parameter in parameters:
        value, reason = result.values[parameter.name], why.get(parameter.name, "")
        error = float("inf")
        if parameter.name in names:
            error = parameter.error(value, float(spread.deviations[names.index(parameter.name)]))
        if not known and parameter.force and not reason:
            reason = "without a known force only its ratio to E is fixed" if parameter.name != "E" else (
                "without a known force its scale is not fixed"
            )  # fmt: skip
        found.append(Found(parameter, start[parameter.name], value, error, not reason, reason))
    return found


def _ratios(start: Mapping[str, float], result: FitResult, spread: Statistics) -> list[Ratio]:
    """Compute the ratios of the force's parameters to E, which the fit held: the relative errors are the same."""
    found = []
    for k, parameter in enumerate(result.parameters):
        if parameter.force:
            value = result.values[parameter.name] / result.values["E"]
            error = parameter.error(result.values[parameter.name], float(spread.deviations[k])) / result.values["E"]
            found.append(Ratio(f"{parameter.name}/E", start[parameter.name] / start["E"], value, error))
    return found


def _compare(simulation: Simulation, used: bool, start: Mapping[str, float], fitted: Mapping[str, float]) -> HeldOut:
    """Compare the configured model and the fitted one on a recording."""
    measured = simulation.recording.position
    apart = []
    for values in (start, fitted):
        distance = np.linalg.norm(
            simulation.predicted_poses(simulation.motion(values), values["delay"]) - measured, axis=1
        )
        apart += [float(np.sqrt(np.mean(distance**2))), float(distance.max())]
    return HeldOut(simulation.recording.name, used, *apart)
