"""Options of an identification."""

from dataclasses import dataclass

from tendond.offline.identification.fitting.solve import Loss
from tendond.offline.identification.simulation.simulate import Drive


@dataclass(frozen=True)
class Options:
    """Options of an identification.

    Attributes:
        parameters: names. drive: source of the tendons' ends; none: the servos' reports where there are any.
        loss: one of `LOSSES`. load_noise: noise of the servos' tensions [N]; none: they are not used.
        jobs: number of threads.
    """

    parameters: tuple[str, ...]
    drive: Drive | None = None
    loss: Loss = "linear"
    load_noise: float | None = None
    jobs: int = 1
