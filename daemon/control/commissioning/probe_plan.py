"""The plan of a probe: its tensions, times and limits.

`python -m tests.constants` has the outcome with half and twice of each constant (docs/reliability.md).
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.rests import RestFamily
from tendond.daemon.control.commissioning.verdict import FOLLOWING, Bounds
from tendond.model.rod.parameters import RodParameters
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

BLOCK_SECONDS = 0.1
"""Duration of the mean of the settled tip's position: half of the default ramp. Half
and twice of it change the probe's duration by -20 and +34 %, no verdict (`python -m tests.constants BLOCK_SECONDS`)."""

DOWN_SECONDS, START_SECONDS = 0.12, 0.16
"""Duration of the release of a tendon, and time after which, it being slack, the next one is pulled:
four cycles at 100 Hz later. Other values, down to half of them, change the probe's duration alone (`python -m
tests.constants DOWN_SECONDS START_SECONDS`)."""

MORE = 1.5
"""Factor on the tension of a second pull, of a tendon that moves the tip too much or too little. 1.25 and 2
change no verdict; a wrong rig's tip moves by 5.5 and 8.2 % of the length (`python -m tests.constants MORE`)."""

STOP_AT = 2.6
"""Motion that ends the probe at once, of the motion asked for: spools of twice the radius move the tip by 6.1 % of
the length in the study, where the default motion is 2 %. With 2 it moves by 5.0 %; with 1.3 most right rigs are refused
(`python -m tests.constants STOP_AT`)."""

SLACK_FACTOR = 2.0
"""Slack of the tendons that are not pulled, in displacements that the motion asks for: 2 r motion / L each.
With 4 a wrong tip moves further, with 0.5 the longest probe takes 1.5 s more (`python -m tests.constants
SLACK_FACTOR`)."""

RELEASE_SECONDS = 0.4
"""Duration of the first release: slow, for a tendon that is reversed is pulled by it: up to 17.6 % of
`limits.tension_max` in `tendond study wiring`, where it may pull 20 %. With half of the time it pulls more, with twice
some probes take 1 s longer (`python -m tests.constants RELEASE_SECONDS`)."""

LOAD_PART = 1.0
"""Reported tension that ends the probe at once, of the probe's largest tension: what no tendon is commanded."""


class Phase(StrEnum):
    """Phase of a probe."""

    REST = "rest"
    PULL = "pull"
    RELEASE = "release"
    DONE = "done"


@dataclass(frozen=True)
class ProbePlan:
    """Plan of a probe; computed once.

    Attributes:
        tensions: tensions of each tendon [N], shape (n,).
        motion: wanted motion of the tip [m].
        stop_at: motion that ends the probe [m]. load_max: reported tension that ends it [N].
        rate: rate of the displacement while tendons are released at first [m/s].
        slack: length by which tendons that are not pulled are released beyond the model's [m]: whatever the wrong
            tendon is that is pulled, it must not find one that holds against it.
        down: for which a tendon is let go; start: after which the next one is pulled; ramp: of its pull; block, rest,
            settling: all in cycles.
            The first release is part of the rest, which is a block longer.
        bounds: range of what passes. arms: positions of the tendons in the cross-section [m], shape (3,) each.
        rests: all that a right rig may have; none: they are not compared.
    """

    tensions: Array
    motion: float
    length: float
    stop_at: float
    load_max: float
    rate: float
    slack: float
    down: int
    start: int
    ramp: int
    block: int
    rest: int
    settling: int
    bounds: Bounds
    arms: tuple[Array, ...]
    rests: RestFamily | None

    @property
    def slack_rest(self) -> tuple[float, float, float] | None:
        """Tip of the configured rod at rest, slack and without a weight [m]; none where rests are not compared."""
        if self.rests is None:
            return None
        nearest = np.argmin(self.rests.weights + np.abs(np.log(self.rests.stiffnesses)))
        x, y, z = self.rests.positions[nearest].tolist()
        return x, y, z

    @staticmethod
    def from_config(config: RigConfig, parameters: RodParameters, rests: RestFamily | None) -> "ProbePlan":
        """Plan by the rod: a tendon at distance r bends it by T r / EI, and its tip goes T r L^2 / 2 EI."""
        section, period = config.commissioning, config.loop.period
        motion = section.motion * parameters.length
        arms = np.hypot(*np.array(parameters.tendon_positions).T)
        wanted = 2.0 * parameters.bending_stiffness * motion / (np.maximum(arms, 1e-6) * parameters.length**2)
        slack = SLACK_FACTOR * 2.0 * motion * float(np.max(arms)) / parameters.length
        largest = section.tension_fraction * config.limits.tension_max
        return ProbePlan(
            tensions=np.minimum(wanted, largest / MORE),
            motion=motion,
            length=parameters.length,
            stop_at=STOP_AT * motion,
            load_max=LOAD_PART * largest,
            rate=slack / RELEASE_SECONDS,
            slack=slack,
            down=max(1, round(DOWN_SECONDS / period)),
            start=max(1, round(START_SECONDS / period)),
            ramp=max(1, round(section.ramp / period)),
            block=max(2, round(BLOCK_SECONDS / period)),
            rest=max(2, round((RELEASE_SECONDS + BLOCK_SECONDS) / period)),
            settling=max(2, round(section.settling / period)),
            bounds=Bounds(section.angle, section.gain_min, section.gain_max, FOLLOWING[1] * float(np.max(arms))),
            arms=tuple(np.array([x, y, 0.0]) for x, y in parameters.tendon_positions),
            rests=rests,
        )


def probe_limits(config: RigConfig) -> LimitsSection:
    """Limits of the command while tendons are probed."""
    largest = config.commissioning.tension_fraction * config.limits.tension_max
    return config.limits.model_copy(update={"tension_min": 0.0, "tension_max": largest})
