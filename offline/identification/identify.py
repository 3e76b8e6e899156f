"""From logs to parameters: check, fit, leave aside what the data do not tell, fit again, compare on other logs."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from tendond.offline.identification.checks import Finding, check, errors
from tendond.offline.identification.data import DataError, Recording
from tendond.offline.identification.fit import FitProblem, FitResult, Loss, Memory, Report, fit, servo_start
from tendond.offline.identification.parameters import PARAMETERS, Parameter, chosen, nominal, starts
from tendond.offline.identification.simulate import Drive, Simulation
from tendond.offline.identification.statistics import ALIKE, Statistics, statistics
from tendond.offline.source_hash import source_hash
from tendond.schemas.config.rig import RigConfig

SOURCES = ("model", "schemas", "offline/identification")
"""Of the package: what a fit's evaluations depend on."""


@dataclass(frozen=True)
class Options:
    """What is asked for.

    Attributes:
        parameters: names. drive: what the tendons' ends are taken from; none: the servos' reports where there are any.
        loss: of `fit.LOSSES`. load_noise: of the servos' tensions [N]; none: they are not used.
        jobs: threads.
    """

    parameters: tuple[str, ...]
    drive: Drive | None = None
    loss: Loss = "linear"
    load_noise: float | None = None
    jobs: int = 1


@dataclass(frozen=True)
class Found:
    """A parameter, and how well it is known.

    Attributes:
        parameter: which. nominal: the configuration's value. value: fitted. error: its standard error.
        found: it may be believed; if not, `why` says why not.
    """

    parameter: Parameter
    nominal: float
    value: float
    error: float
    found: bool
    why: str = ""


@dataclass(frozen=True)
class Ratio:
    """Two parameters' ratio, where the scale of force is not known.

    Attributes:
        name: as 'rho/E'. value, error: of it; nominal: by the configuration.
    """

    name: str
    nominal: float
    value: float
    error: float


@dataclass(frozen=True)
class HeldOut:
    """How well models do on a recording: root mean square and largest distance of the tips [m].

    Attributes:
        name: of the log. used: for the fit.
    """

    name: str
    used: bool
    nominal_rms: float
    nominal_max: float
    fitted_rms: float
    fitted_max: float


@dataclass(frozen=True)
class Identification:
    """The result.

    Attributes:
        config: of the rig, as in the first log.
        drive: what the tendons' ends were taken from.
        findings: about the logs.
        parameters: that were asked for.
        ratios: that are known instead, where the scale of force is not.
        scale: what fixes the scale of force, in words.
        fit, statistics: of the last fit, in which all parameters are identifiable.
        held_out: of all recordings.
        noise: of the poses [m]. rms: of the poses' residuals, a coordinate [m].
        simulations: of the recordings used; others: of those held out.
        first: of the first fit, in which all that was asked for was free.
    """

    config: RigConfig
    drive: Drive
    findings: tuple[Finding, ...]
    parameters: tuple[Found, ...]
    ratios: tuple[Ratio, ...]
    scale: str
    fit: FitResult
    statistics: Statistics
    held_out: tuple[HeldOut, ...]
    noise: float
    rms: float
    simulations: tuple[Simulation, ...]
    others: tuple[Simulation, ...]
    first: Statistics

    @property
    def values(self) -> dict[str, float]:
        """Of the parameters that were found, by name."""
        return {found.parameter.name: found.value for found in self.parameters if found.found}


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
        recordings: to fit to; at least one.
        held_out: to compare on.
        options: of the fit.
        report: called with the progress.
        memory: folder of what an interrupted fit has computed; none: nothing is kept.
        tell: called with findings about the logs, before the fit.

    Raises:
        DataError: logs that cannot be fitted to.
        UsageError: parameters that cannot be fitted.
        FitError, SimulationError: no result.
    """
    parameters = chosen(options.parameters)
    drive = options.drive or ("measured" if all(r.has_reports for r in recordings) else "command")
    everything = [*recordings, *held_out]
    findings = check(everything, drive)
    for finding in findings:
        tell(finding)
    bad = errors(findings)
    if bad:
        raise DataError("\n".join(finding.text for finding in bad))
    config = recordings[0].config
    starts(config, parameters)  # refused before anything is computed
    scale, known = _scale(recordings, parameters, options)
    simulations = tuple(Simulation(recording, drive) for recording in recordings)
    noise = float(np.median([recording.noise for recording in recordings])) or 1e-5
    kept = Memory(memory, {
        "logs": [_digest(recording) for recording in recordings], "options": asdict(options) | {"jobs": 0},
        "source": source_hash(SOURCES), "drive": drive,
    })  # fmt: skip
    why: dict[str, str] = {}
    free = list(parameters)
    if known and _weight_hides_tip_mass(recordings, parameters, options):
        why["tip_mass"] = "the same weight hangs in every log, and only the sum is seen: add a log without it"
        free = [parameter for parameter in free if parameter.name != "tip_mass"]
        scale += f", beside rod.tip_mass = {nominal(config)['tip_mass']:g} kg, which these logs cannot check"
    if not known:
        free = [parameter for parameter in free if parameter.name != "E"]
    first: Statistics | None = None
    while True:
        if not free:
            raise DataError("the logs tell none of the parameters: " + "; ".join(why.values()))
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
    """Of all that a fit takes from a recording."""
    digest = hashlib.sha256(recording.config.model_dump_json().encode())
    for array in (recording.times, recording.command, recording.reported, recording.pose_times, recording.position):
        digest.update(np.ascontiguousarray(array).tobytes())
    digest.update(repr(recording.weight).encode())
    return digest.hexdigest()


def _scale(recordings: Sequence[Recording], parameters: Sequence[Parameter], options: Options) -> tuple[str, bool]:
    """What fixes the scale of force, in words, and whether anything does."""
    names = {parameter.name for parameter in parameters}
    forces = [parameter.name for parameter in parameters if parameter.force]
    weights = sorted({recording.weight for recording in recordings if recording.weight > 0.0})
    if not forces:
        return "not asked: no parameter goes with it", True
    if weights:
        shown = ", ".join(f"{weight * 1e3:g} g" for weight in weights)
        return f"the known weight on the tip: {shown}", True
    if options.load_noise is not None:
        return (
            f"the servos' load, taken to be right to {options.load_noise:g} N; an error of its scale is one of E's",
            True,
        )
    values = nominal(recordings[0].config)
    for held in ("rho", "E", "tip_mass"):
        if held not in names and values[held] > 0.0:
            key = PARAMETERS[held].key
            return f"{held}, which is not fitted: all others rest on rod.{key} = {values[held]:g}", True
    return (
        "nothing: displacements and poses fix only ratios of E, rho, Bbt, C, tendon_stiffness and tip_mass. Record a "
        "log with a known weight on the tip ('tendond identify run --weight 0.05'), use the servos' load (--load 2), "
        "or leave out a parameter that you have measured otherwise (rho, by weighing)",
        False,
    )


def _weight_hides_tip_mass(recordings: Sequence[Recording], parameters: Sequence[Parameter], options: Options) -> bool:
    """Whether a weight fixes the scale of force alone, and is never off: then it is one with the body on the tip."""
    names = {parameter.name for parameter in parameters}
    alone = options.load_noise is None and {"E", "rho", "tip_mass"} <= names
    return alone and recordings[0].weight > 0.0 and len({recording.weight for recording in recordings}) == 1


def _lost(result: FitResult, spread: Statistics) -> dict[str, str]:
    """Return the parameters that are not identifiable, with the reason."""
    names = [parameter.name for parameter in result.parameters]
    lost: dict[str, str] = {}
    for k, parameter in enumerate(result.parameters):
        deviation = spread.deviations[k]
        if parameter.name in result.bounded and not _is_none(parameter, result):
            lost[parameter.name] = (
                f"it went to the end of its range, {result.values[parameter.name]:.4g} {parameter.unit}"
            )
        elif not deviation <= parameter.max_deviation:
            alike = [names[i] for i in range(len(names)) if i != k and abs(spread.correlation[k, i]) > ALIKE]
            together = [name for direction in spread.unidentifiable if parameter.name in direction.names
                        for name in direction.names if name != parameter.name]  # fmt: skip
            partners = list(dict.fromkeys(alike + together))
            if partners:
                lost[parameter.name] = f"these data cannot tell it from {', '.join(partners)}"
            else:
                lost[parameter.name] = "these data hardly depend on it"
    return lost


def _is_none(parameter: Parameter, result: FitResult) -> bool:
    """A delay, lag, backlash or mass on the tip of zero is a result."""
    return parameter.lower < 1e-3 and not parameter.logarithmic and result.values[parameter.name] < 1e-3


def _found(
    parameters: Sequence[Parameter], start: Mapping[str, float], result: FitResult, spread: Statistics,
    why: Mapping[str, str], known: bool,
) -> list[Found]:  # fmt: skip
    """Each parameter that was asked for."""
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
    """Of the force's parameters to E, which the fit held: their relative errors are the ratios'."""
    found = []
    for k, parameter in enumerate(result.parameters):
        if parameter.force:
            value = result.values[parameter.name] / result.values["E"]
            error = parameter.error(result.values[parameter.name], float(spread.deviations[k])) / result.values["E"]
            found.append(Ratio(f"{parameter.name}/E", start[parameter.name] / start["E"], value, error))
    return found


def _compare(simulation: Simulation, used: bool, start: Mapping[str, float], fitted: Mapping[str, float]) -> HeldOut:
    """The configuration's model and the fitted one on a recording."""
    measured = simulation.recording.position
    apart = []
    for values in (start, fitted):
        distance = np.linalg.norm(simulation.seen(simulation.motion(values), values["delay"]) - measured, axis=1)
        apart += [float(np.sqrt(np.mean(distance**2))), float(distance.max())]
    return HeldOut(simulation.recording.name, used, *apart)
