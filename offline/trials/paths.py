"""Trajectories that are run, and the plants they are run on."""

import math
from dataclasses import dataclass, field
from typing import Any

from tendond.model.rods.selection import model_rod
from tendond.offline.robustness.unlike import load_factor, unlike
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.robot import RodSection

MATCHED_RMS_MM, UNLIKE_RMS_MM = 1.0, 15.0
"""Goals: on the model itself, and on the plant unlike it, whose unknown mass bounds the observer's gains."""

UNLIKE = "2 cycles of delay, 0.1 mm noise, E -10 %, 20 g"
UNLIKE_STIFFNESS, UNLIKE_MASS = 0.9, 0.02
"""Factor on the plant's stiffness [-], and mass on the tip of the paper's robot [kg]; see `unlike.load_factor`."""

MATCHED = "the model itself"


@dataclass(frozen=True)
class Trial:
    """A trajectory on a plant.

    Attributes:
        name: name of the trajectory.
        reference: its [reference].
        unlike: the plant is not the model: `UNLIKE`.
        rod: keys of [rod] beside the configuration's.
        size: of the robot, of the one that the goals are for [-].
    """

    name: str
    reference: dict[str, Any]
    unlike: bool = False
    rod: dict[str, Any] = field(default_factory=dict)
    size: float = 1.0

    @property
    def plant(self) -> str:
        return UNLIKE if self.unlike else MATCHED

    @property
    def goal_mm(self) -> float:
        return self.size * (UNLIKE_RMS_MM if self.unlike else MATCHED_RMS_MM)

    @property
    def file(self) -> str:
        """Name of its figure."""
        return self.name.replace(" ", "-").replace(",", "").replace(".", "") + ("-unlike" if self.unlike else "")


SIZE = 0.5
"""Length of the robot that the trajectories are given for, the paper's [m]."""


def around(count: int, radius: float = 0.02) -> list[tuple[float, float]]:
    """Place tendons evenly around the rod [m]."""
    angles = [2.0 * math.pi * index / count for index in range(count)]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]


def trials(base: RigConfig | None = None) -> list[Trial]:
    """List all trials, each on both plants, in the size of a configuration's robot; default: the paper's.

    The robot's own tendons are replaced by other numbers of them only where it is one uniform section.
    """
    rod = (base or RigConfig()).rod
    size = rod.length / SIZE
    found = []
    for unlike_model in (False, True):
        for radius in (0.1 * size, 0.25 * size, 0.32 * size):
            for period in (2.0, 4.0):
                trajectory = {"kind": "circle", "radius": radius, "period": period}
                found.append(Trial(f"circle {radius * 1e3:.0f} mm, {period:g} s", trajectory, unlike_model, size=size))
        eight = {"kind": "figure_eight", "radius": 0.3 * size, "period": 4.0}
        helix = {"kind": "helix", "radius": 0.3 * size, "radius_end": 0.08 * size, "period": 3.0, "laps": 3}
        start, end = (-0.25 * size, -0.1 * size), (0.25 * size, 0.1 * size)
        line = {"kind": "line", "start": start, "end": end, "period": 3.0}
        found.append(Trial("figure-eight", eight, unlike_model, size=size))
        found.append(Trial("helix", helix, unlike_model, size=size))
        found.append(Trial("line through the straight rod", line, unlike_model, size=size))
        circle = {"kind": "circle", "radius": 0.25 * size, "period": 4.0}
        for count in () if rod.not_uniform else (3, 6):
            tendons = {"tendon_positions": around(count, 0.02 * size)}
            found.append(Trial(f"circle, {count} tendons", circle, unlike_model, tendons, size))
    return found


def config_of(base: RigConfig, trial: Trial, seed: int = 0) -> RigConfig:
    """Controller and plant of a trial.

    Args:
        base: the controller's configuration; its [rod] is the plant's too, but for what the trial says.
        trial: the trial to run.
        seed: seed of the noise.

    Raises:
        ConfigError: they do not go together.
    """
    values = base.model_dump()
    values["rod"].update(trial.rod)
    values["control"]["law"] = "sensitivity"
    values["reference"] = trial.reference
    values["servo"] = values["vicon"] = None
    model = RodSection.model_validate(values["rod"])
    plant = unlike(model, UNLIKE_STIFFNESS) if trial.unlike else model
    values["simulator"] = {"period": base.loop.period, "rod": plant.model_dump(), "seed": seed}
    if trial.unlike:
        delay = 2.0 * base.loop.period
        values["observer"]["delay"] = delay
        mass = UNLIKE_MASS * load_factor(model_rod(base).parameters)
        values["simulator"] |= {"weight": {"mass": mass}, "mocap": {"noise": 1e-4, "latency": delay}}
    return check_config(values, f"trial '{trial.name}'")
