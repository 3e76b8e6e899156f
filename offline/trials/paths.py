"""Trajectories that are run, and the plants they are run on."""

import math
from dataclasses import dataclass, field
from typing import Any

from tendond.schemas.config.rig import RigConfig, check_config

MATCHED_RMS_MM, UNLIKE_RMS_MM = 1.0, 15.0
"""Goals: on the model itself, and on the plant unlike it, whose unknown mass bounds the observer's gains."""

UNLIKE = "2 cycles of delay, 0.1 mm noise, E -10 %, 20 g"
MATCHED = "the model itself"


@dataclass(frozen=True)
class Trial:
    """A trajectory on a plant.

    Attributes:
        name: name of the trajectory.
        reference: its [reference].
        unlike: the plant is not the model: `UNLIKE`.
        rod: keys of [rod] beside the configuration's.
    """

    name: str
    reference: dict[str, Any]
    unlike: bool = False
    rod: dict[str, Any] = field(default_factory=dict)

    @property
    def plant(self) -> str:
        return UNLIKE if self.unlike else MATCHED

    @property
    def goal_mm(self) -> float:
        return UNLIKE_RMS_MM if self.unlike else MATCHED_RMS_MM

    @property
    def file(self) -> str:
        """Name of its figure."""
        return self.name.replace(" ", "-").replace(",", "").replace(".", "") + ("-unlike" if self.unlike else "")


def around(count: int, radius: float = 0.02) -> list[tuple[float, float]]:
    """Place tendons evenly around the rod [m]."""
    angles = [2.0 * math.pi * index / count for index in range(count)]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]


def trials() -> list[Trial]:
    """List all trials, each on both plants."""
    found = []
    for unlike in (False, True):
        for radius in (0.1, 0.25, 0.32):
            for period in (2.0, 4.0):
                trajectory = {"kind": "circle", "radius": radius, "period": period}
                found.append(Trial(f"circle {radius * 1e3:.0f} mm, {period:g} s", trajectory, unlike))
        eight = {"kind": "figure_eight", "radius": 0.3, "period": 4.0}
        helix = {"kind": "helix", "radius": 0.3, "radius_end": 0.08, "period": 3.0, "laps": 3}
        line = {"kind": "line", "start": (-0.25, -0.1), "end": (0.25, 0.1), "period": 3.0}
        found.append(Trial("figure-eight", eight, unlike))
        found.append(Trial("helix", helix, unlike))
        found.append(Trial("line through the straight rod", line, unlike))
        circle = {"kind": "circle", "radius": 0.25, "period": 4.0}
        for count in (3, 6):
            found.append(Trial(f"circle, {count} tendons", circle, unlike, {"tendon_positions": around(count)}))
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
    plant = dict(values["rod"])
    values["simulator"] = {"period": base.loop.period, "rod": plant, "seed": seed}
    if trial.unlike:
        delay = 2.0 * base.loop.period
        plant["youngs_modulus"] = 0.9 * plant["youngs_modulus"]
        values["observer"]["delay"] = delay
        values["simulator"] |= {"weight": {"mass": 0.02}, "mocap": {"noise": 1e-4, "latency": delay}}
    return check_config(values, f"trial '{trial.name}'")
