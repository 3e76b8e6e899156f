"""The one place that bounds a command: tension, its rate, displacement, its rate; and never anything but finite."""

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.config import LimitsSection

Array = NDArray[np.float64]


def limit_tension(limits: LimitsSection, period: float, wanted: Array, last: Array) -> tuple[Array, tuple[str, ...]]:
    """`wanted` within tension and tension rate, and the names of the limits that it met.

    Args:
        limits: of the configuration.
        period: of the cycle [s].
        wanted: [N], shape (n,); a value that is not finite counts as no change.
        last: commanded in the last cycle [N], shape (n,).
    """
    met = []
    tension = np.where(np.isfinite(wanted), wanted, last)
    if not np.all(np.isfinite(wanted)):
        met.append("not finite")
    step = limits.tension_rate * period
    rated = np.clip(tension, last - step, last + step)
    if np.any(rated != tension):
        met.append("tension rate")
    bounded = np.clip(rated, limits.tension_min, limits.tension_max)
    if np.any(rated > limits.tension_max):
        met.append("tension max")
    if np.any(rated < limits.tension_min):
        met.append("tension min")
    return bounded, tuple(met)


def limit_displacement(
    limits: LimitsSection, period: float, wanted: Array, last: Array
) -> tuple[Array, tuple[str, ...]]:
    """`wanted` displacement within its range and rate [m], shape (n,), and the names of the limits that it met."""
    met = []
    step = limits.displacement_rate * period
    rated = np.clip(wanted, last - step, last + step)
    if np.any(rated != wanted):
        met.append("displacement rate")
    bounded = np.clip(rated, limits.displacement_min, limits.displacement_max)
    if np.any(bounded != rated):
        met.append("displacement")
    return bounded, tuple(met)
