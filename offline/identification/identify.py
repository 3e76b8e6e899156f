"""Identification from logs: check, fit, hold what the data do not identify, fit again, compare on other logs."""

import hashlib
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from pathlib import Path

import numpy as np

from tendond.offline.identification.candidates import candidates
from tendond.offline.identification.configured import absent, nominal, parameters_of, starts
from tendond.offline.identification.fitting.candidate import Trial
from tendond.offline.identification.fitting.evaluations import EvaluationCache
from tendond.offline.identification.fitting.identifiable import fit_identifiable
from tendond.offline.identification.fitting.problem import FitProblem, Report
from tendond.offline.identification.fitting.selection import select
from tendond.offline.identification.fitting.servo_start import servo_start
from tendond.offline.identification.fitting.solve import FitResult, fit
from tendond.offline.identification.force_scale import force_scale, weight_hides_tip_mass
from tendond.offline.identification.options import Options
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.parameters import DYNAMIC, FROM, GENERAL, PARAMETERS, chosen
from tendond.offline.identification.recordings.checks import Finding, check, errors
from tendond.offline.identification.recordings.recording import DataError, Drive, Recording
from tendond.offline.identification.recordings.rests import has_only_rests
from tendond.offline.identification.results.collect import compare, found_parameters, ratios_to_modulus
from tendond.offline.identification.results.result import Identification
from tendond.offline.identification.simulation.rests import StaticSimulation
from tendond.offline.identification.simulation.simulate import Simulation
from tendond.offline.identification.simulation.simulated import Simulated
from tendond.offline.source_hash import source_hash

SOURCES = ("model", "schemas", "offline/identification")
"""Modules of the package that a fit's evaluations depend on."""

AT_REST = "rests do not depend on it: record motion"
NO_PLAY = "the servos' reports at rest do not show it: fit to the commands (--drive command), or record motion"


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
    drive = options.drive or ("measured" if all(r.has_reports for r in recordings) else "command")
    statics = all(map(has_only_rests, recordings)) if options.statics is None else options.statics
    trials: list[Trial] = []
    if options.parameters is None:
        forced = options.load_noise is not None or any(recording.weight > 0.0 for recording in recordings)
        forced = forced or any(PARAMETERS[name].force for name in options.priors)
        tried, trials = candidates(config, _unseen(PARAMETERS.values(), drive) if statics else {}, forced)
        parameters = tuple(parameter for one in tried for parameter in one.parameters)
    else:
        parameters = parameters_of(config.rod, chosen(options.parameters))
    why = absent(config, parameters) | (_unseen(parameters, drive) if statics else {})
    free = [parameter for parameter in parameters if parameter.name not in why]
    simulate = partial(_simulation, drive=drive, statics=statics, general=any(one.name in GENERAL for one in free))
    findings = check([*recordings, *held_out], drive, simulate, not any(one.section == "rod.base" for one in free))
    for finding in findings:
        tell(finding)
    bad = errors(findings)
    if bad:
        raise DataError("\n".join(finding.text for finding in bad))
    starts(config, free)  # refused before anything is computed
    simulations = tuple(simulate(recording) for recording in recordings)
    noise = float(np.median([simulation.recording.noise for simulation in simulations])) or 1e-5
    begin: dict[str, float] = {}

    def problem_of(some: Sequence[Parameter], start: Mapping[str, float], prior_scale: float = noise) -> FitProblem:
        return FitProblem(
            simulations, some, start, options.load_noise, options.jobs, report, options.priors, prior_scale
        )  # fmt: skip

    if options.parameters is None:
        selected = select(tried, nominal(config), problem_of, noise)
        order = {parameter.name: place for place, parameter in enumerate(free)}
        free = sorted(selected.parameters, key=lambda one: order[one.name])
        parameters, begin, trials = tuple(free), selected.values, [*selected.trials, *trials]
    scale, known = force_scale(recordings, free, options)
    kept = EvaluationCache(memory, {
        "logs": [_digest(recording) for recording in recordings], "options": asdict(options) | {"jobs": 0},
        "source": source_hash(SOURCES), "drive": drive, "statics": statics,
    })  # fmt: skip
    if known and weight_hides_tip_mass(recordings, parameters, options):
        why["tip_mass"] = "the same weight hangs in every log, so only the sum is identifiable: add a log without it"
        free = [parameter for parameter in free if parameter.name != "tip_mass"]
        scale += f", in addition to rod.tip_mass = {nominal(config)['tip_mass']:g} kg, which these logs cannot check"
    if not known:
        free = [parameter for parameter in free if parameter.name != "E"]

    def fit_of(some: Sequence[Parameter]) -> FitResult:
        start = starts(config, some)
        start |= {one.name: max(begin[one.name], FROM.get(one.name, -math.inf)) for one in some if one.name in begin}
        first = servo_start(simulations, some, start)
        result = fit(problem_of(some, start), kept, options.loss, noise, first)
        if any(one.name in options.priors for one in some) and rms_of(result) > noise:
            # A prior weighs as its sigma against what the poses are really off.
            wider = problem_of(some, start, rms_of(result))
            result = fit(wider, EvaluationCache(None, {}), options.loss, noise, result.coordinates)
        return result

    done = fit_identifiable(free, why, fit_of)
    kept.forget()
    result, spread = done.result, done.statistics
    others = tuple(simulate(recording) for recording in held_out)
    nominal_values = nominal(config)
    return Identification(
        config=config,
        drive=drive,
        statics=statics,
        findings=tuple(findings),
        parameters=tuple(found_parameters(parameters, nominal_values, result, spread, done.why, known, options.priors)),
        ratios=() if known else tuple(ratios_to_modulus(nominal_values, result, spread)),
        scale=scale,
        fit=result,
        statistics=spread,
        held_out=tuple(
            compare(simulation, used, nominal_values, result.values)
            for group, used in ((simulations, True), (others, False))
            for simulation in group
        ),
        noise=noise,
        rms=rms_of(result),
        simulations=simulations,
        others=others,
        first=done.first,
        trials=tuple(trials),
    )


def _simulation(recording: Recording, drive: Drive, statics: bool, general: bool) -> Simulated:
    return StaticSimulation(recording, drive) if statics else Simulation(recording, drive, general=general)


def rms_of(result: FitResult) -> float:
    """Return the root mean square of the poses' residuals, a coordinate [m]."""
    return float(np.sqrt(np.mean(np.concatenate([blocks[0].ravel() for blocks in result.residuals]) ** 2)))


def _unseen(parameters: Iterable[Parameter], drive: Drive) -> dict[str, str]:
    """Return the parameters that rests do not show, with the reasons."""
    found = {one.name: AT_REST for one in parameters if one.name in DYNAMIC}
    if drive == "measured":
        found |= {one.name: NO_PLAY for one in parameters if one.name == "backlash"}
    return found


def _digest(recording: Recording) -> str:
    """Hash all that a fit uses of a recording."""
    digest = hashlib.sha256(recording.config.model_dump_json().encode())
    for array in (recording.times, recording.command, recording.reported, recording.pose_times, recording.position):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(repr(recording.weight).encode())
    return digest.hexdigest()
