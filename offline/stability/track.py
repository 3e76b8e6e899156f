"""Runs of robots on their references: does a law reach its target at a rate, and rest there?"""

import math
from dataclasses import dataclass

import numpy as np

from tendond.daemon.errors import DaemonError
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.errors import ModelError
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.selection import model_rod
from tendond.offline.stability.cases import Case, configured, held
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

BEND = 60.0
"""Bend at the target of the runs [degrees]."""

SECONDS = 6.0
"""Length of a run [s]."""

LAST = 1.0
"""Time at the end in which the tip is to rest [s]."""

MISSING, RIPPLE = 2e-3, 2e-3
"""Largest distance from the target at the end, and largest motion of the tip in the last second, over the length [-]:
0.4 mm of a robot of 200 mm. Chosen before the runs."""


@dataclass(frozen=True)
class Tracked:
    """What a run comes to.

    Attributes:
        robot: preset. law: that ran, chosen from the robot where none was asked for. rate: of the loop [Hz].
        mode: at the end. missing: distance of the true tip from its target across, at the end, over the length [-].
        ripple: its motion in the last second, largest of the components, over the length [-].
        why: reason of the last mode, or why the run did not begin.
    """

    robot: str
    law: str
    rate: float
    mode: str
    missing: float
    ripple: float
    why: str

    @property
    def settled(self) -> bool:
        """True if the tip rests at its target."""
        return self.mode == Mode.TRACKING.value and self.missing < MISSING and self.ripple < RIPPLE


def rested(robot: str, law: str | None, rate: float) -> RigConfig:
    """Return the configuration of a run: the robot bent by its agonist, with tensions that suit it.

    Args:
        robot: preset. law: name; none: as the configuration chooses. rate: of the loop [Hz].
    """
    plain = configured(Case(robot, rate=rate))
    rod = model_rod(plain)
    assert isinstance(rod, GeneralRod)
    tension, place = held(plain, rod, math.radians(BEND))
    most = float(tension.max())
    least = min(1.0, 0.05 * most)
    data = {
        "rod": {"preset": robot},
        "loop": {"period": 1.0 / rate},
        "control": {} if law is None else {"law": law},
        "commissioning": {"rest": False, "probe": False},
        "simulator": {"period": 1.0 / rate},
        "limits": {"tension_max": min(500.0, 3.0 * most + 1.0)},
        "pretension": {"tension": min(0.5, 0.1 * most), "tension_min": least},
        "reference": {"kind": "minimum_jerk", "duration": 1.0, "across": place[0]},
    }
    return check_config(data, f"{robot} at {rate:g} Hz")


def track(robot: str, law: str | None, rate: float, seconds: float = SECONDS) -> Tracked:
    """Run a robot from rest to its target.

    Args:
        robot: preset. law: name; none: as the configuration chooses. rate: of the loop [Hz]. seconds: of the run.
    """
    config = rested(robot, law, rate)
    length = config.rod.backbone_length
    name = config.control.law
    try:
        runs = list(watched_loop(config, round(seconds * rate), {2: ControlAction.ARM}))
    except (DaemonError, ModelError) as error:
        return Tracked(robot, name, rate, "none", math.inf, math.inf, str(error).splitlines()[0])
    record = runs[-1].record
    tips = np.array([one.truth.position for one in runs[-round(LAST * rate) :]])
    missing = math.hypot(*(tips[-1] - np.array(record.reference.position))[:2].tolist())
    ripple = float(np.ptp(tips, axis=0).max())
    return Tracked(robot, record.law, rate, record.mode.value, missing / length, ripple / length, record.reason)
