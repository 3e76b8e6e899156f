"""A fit of what the data identify: what they do not is held, with the reason, and the rest is fitted again."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from tendond.offline.identification.fitting.solve import FitResult
from tendond.offline.identification.fitting.statistics import ALIKE, Statistics, statistics
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.recordings.recording import DataError


@dataclass(frozen=True)
class IdentifiableFit:
    """A fit in which all parameters are identifiable.

    Attributes:
        result, statistics: of the last fit. first: statistics of the first one, in which all parameters were free.
        why: reasons of those that are held, by name.
    """

    result: FitResult
    statistics: Statistics
    first: Statistics
    why: dict[str, str]


def fit_identifiable(
    free: Sequence[Parameter], why: Mapping[str, str], fit: Callable[[Sequence[Parameter]], FitResult]
) -> IdentifiableFit:
    """Fit, hold what is not identifiable, and fit again, until all of it is.

    Args:
        free: parameters to fit. why: reasons of those that are held already. fit: fits some of them.

    Raises:
        DataError: nothing remains.
    """
    free, held = list(free), dict(why)
    first: Statistics | None = None
    while True:
        if not free and held:
            raise DataError("the logs identify none of the parameters: " + "; ".join(held.values()))
        result = fit(free)
        spread = statistics(result)
        first = first or spread
        lost = _lost(result, spread)
        if not lost:
            return IdentifiableFit(result, spread, first, held)
        held |= lost
        free = [parameter for parameter in free if parameter.name not in lost]


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
