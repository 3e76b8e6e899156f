"""The result of an identification."""

from dataclasses import dataclass

from tendond.offline.identification.fitting.candidate import Trial
from tendond.offline.identification.fitting.solve import FitResult
from tendond.offline.identification.fitting.statistics import Statistics
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.priors import Prior
from tendond.offline.identification.recordings.checks import Finding
from tendond.offline.identification.recordings.recording import Drive
from tendond.offline.identification.simulation.simulated import Simulated
from tendond.schemas.config.rig import RigConfig

LEARNED = 0.8
"""Error in parts of the prior's sigma above which the prior, and below the rest of one the data, decide a value."""


@dataclass(frozen=True)
class Found:
    """An identified parameter with its standard error.

    Attributes:
        parameter: the parameter. nominal: the configured value. value: the fitted one. error: its standard error.
        found: true if it was identified; if not, `why` gives the reason. prior: what was known of it; none: nothing.
    """

    parameter: Parameter
    nominal: float
    value: float
    error: float
    found: bool
    why: str = ""
    prior: Prior | None = None

    @property
    def decided(self) -> str:
        """Whether data or prior decide the value; empty without a prior."""
        if self.prior is None or not self.found:
            return ""
        share = self.error / self.prior.sigma
        return "prior" if share > LEARNED else "data" if share < 1.0 - LEARNED else "both"


@dataclass(frozen=True)
class Ratio:
    """A ratio of two parameters, where the scale of force is not known.

    Attributes:
        name: name such as 'rho/E'. value, error: the ratio and its standard error. nominal: the configured ratio.
    """

    name: str
    nominal: float
    value: float
    error: float


@dataclass(frozen=True)
class HeldOut:
    """Distances of the models' tips from a recording: root mean square and maximum [m].

    Attributes:
        name: name of the log. used: true if it was fitted to.
    """

    name: str
    used: bool
    nominal_rms: float
    nominal_max: float
    fitted_rms: float
    fitted_max: float


@dataclass(frozen=True)
class Identification:
    """The result of an identification.

    Attributes:
        config: the rig's configuration in the first log.
        drive: source of the tendons' ends. statics: true where the rests were fitted, not the motion.
        findings: problems of the logs.
        parameters: the requested parameters.
        ratios: ratios that are known instead, where the scale of force is not.
        scale: source of the scale of force, in words.
        fit, statistics: the last fit, in which all parameters are identifiable.
        held_out: comparisons on all recordings.
        noise: noise of the poses [m]. rms: root mean square of the poses' residuals, per coordinate [m].
        simulations: simulations of the recordings used. others: those of the recordings held out.
        trials: of the selection of the parameters; empty where they were given.
        first: statistics of the first fit, in which all requested parameters were free.
    """

    config: RigConfig
    drive: Drive
    statics: bool
    findings: tuple[Finding, ...]
    parameters: tuple[Found, ...]
    ratios: tuple[Ratio, ...]
    scale: str
    fit: FitResult
    statistics: Statistics
    held_out: tuple[HeldOut, ...]
    noise: float
    rms: float
    simulations: tuple[Simulated, ...]
    others: tuple[Simulated, ...]
    first: Statistics
    trials: tuple[Trial, ...] = ()

    @property
    def values(self) -> dict[str, float]:
        """Values of the identified parameters, by name."""
        return {found.parameter.name: found.value for found in self.parameters if found.found}
