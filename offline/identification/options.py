"""Options of an identification."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from tendond.offline.identification.fitting.solve import Loss
from tendond.offline.identification.priors import Prior
from tendond.offline.identification.recordings.recording import Drive


@dataclass(frozen=True)
class Options:
    """Options of an identification.

    Attributes:
        parameters: names; none: those that the logs support.
        drive: source of the tendons' ends; none: the servos' reports where there are any.
        loss: one of `LOSSES`. load_noise: noise of the servos' tensions [N]; none: they are not used.
        jobs: number of threads. statics: true: the rests are fitted, false: the motion; none: by the logs.
        priors: what is known of parameters, by name.
    """

    parameters: tuple[str, ...] | None
    drive: Drive | None = None
    loss: Loss = "linear"
    load_noise: float | None = None
    jobs: int = 1
    statics: bool | None = None
    priors: Mapping[str, Prior] = field(default_factory=dict)
