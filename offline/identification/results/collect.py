"""Results of a fit, parameter by parameter and recording by recording."""

from collections.abc import Mapping, Sequence

import numpy as np

from tendond.offline.identification.fitting.solve import FitResult
from tendond.offline.identification.fitting.statistics import Statistics
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.priors import Prior
from tendond.offline.identification.results.result import Found, HeldOut, Ratio
from tendond.offline.identification.simulation.simulated import Simulated


def found_parameters(
    parameters: Sequence[Parameter], start: Mapping[str, float], result: FitResult, spread: Statistics,
    why: Mapping[str, str], known: bool, priors: Mapping[str, Prior],
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
        found.append(
            Found(parameter, start[parameter.name], value, error, not reason, reason, priors.get(parameter.name))
        )
    return found


def ratios_to_modulus(start: Mapping[str, float], result: FitResult, spread: Statistics) -> list[Ratio]:
    """Compute the ratios of the force's parameters to E, which the fit held: the relative errors are the same."""
    found = []
    for k, parameter in enumerate(result.parameters):
        if parameter.force:
            value = result.values[parameter.name] / result.values["E"]
            error = parameter.error(result.values[parameter.name], float(spread.deviations[k])) / result.values["E"]
            found.append(Ratio(f"{parameter.name}/E", start[parameter.name] / start["E"], value, error))
    return found


def compare(simulation: Simulated, used: bool, start: Mapping[str, float], fitted: Mapping[str, float]) -> HeldOut:
    """Compare the configured model and the fitted one on a recording."""
    measured = simulation.recording.position
    apart = []
    for values in (start, fitted):
        distance = np.linalg.norm(
            simulation.predicted_poses(simulation.motion(values), values["delay"]) - measured, axis=1
        )
        apart += [float(np.sqrt(np.mean(distance**2))), float(distance.max())]
    return HeldOut(simulation.recording.name, used, *apart)
