"""Which whole turn a servo is on: one function for the driver and for every tool.

A servo counts its turns while it has power, from wherever it stood at power-up. So one position stands for several
displacements, a turn of the spool apart. What decides is where the tendon was last known to be: without torque it can
only have gone from there towards its zero, because the robot straightens, but never beyond.
"""

import math
from dataclasses import dataclass

from tendond.drivers.dynamixel.calibration import TendonCalibration
from tendond.drivers.dynamixel.serial.table import TICKS_PER_TURN
from tendond.drivers.dynamixel.spool import Spool
from tendond.schemas.config.servo import ServoSection

FURTHER = 0.125
"""Of a turn, by which a tendon may stand beyond the last known place: the servo went on while nobody wrote it down. On
a spool of 15 mm that is what 85 mm/s go in 0.14 s."""


@dataclass(frozen=True)
class Located:
    """A spool with the turn that is believed.

    Attributes:
        spool: with that turn.
        displacement: of the tendon [m].
        others: displacements that it may as well have [m]; empty where the turn is certain.
    """

    spool: Spool
    displacement: float
    others: tuple[float, ...] = ()

    @property
    def turn(self) -> float:
        """Displacement of a whole turn [m]."""
        return 2.0 * math.pi * self.spool.calibration.spool_radius

    @property
    def certain(self) -> bool:
        """Only one turn is possible."""
        return not self.others

    @property
    def doubt(self) -> str:
        """Which displacements are possible, in words; empty where only one is."""
        if self.certain:
            return ""
        places = " or ".join(f"{place * 1e3:.1f}" for place in sorted((self.displacement, *self.others), reverse=True))
        return f"stands at {places} mm: its servo has lost its turns, and nothing tells which"


def locate(section: ServoSection, tendon: TendonCalibration, position: int, last: float | None) -> Located:
    """Find the turn that a servo is on.

    Args:
        section: [servo].
        tendon: its calibration.
        position: that it reports [ticks].
        last: displacement that the tendon was last known to have [m]; none where nothing is known.
    """
    nearest = round((position - tendon.zero) / TICKS_PER_TURN)
    turn = 2.0 * math.pi * tendon.spool_radius
    reach = math.ceil(max(section.displacement_max, -section.displacement_min) / turn) + 1
    places = {(spool := Spool(tendon, nearest + k)): spool.displacement(position) for k in range(-reach, reach + 1)}
    wanted = 0.0 if last is None else last
    best = min(places, key=lambda spool: abs(places[spool] - wanted))
    if last is None and abs(places[best]) <= section.home_window:
        return Located(best, places[best])  # the configuration sees to it that no other turn is within the travel
    further = FURTHER * turn
    travel = (section.displacement_min - further, section.displacement_max + further)
    if last is None:
        low, high = travel
    else:
        low = min(-section.home_window, last - further)
        high = max(section.home_window, last + further)
    possible = {spool for spool, place in places.items() if low <= place <= high}
    if len(possible) == 1:
        (best,) = possible
        return Located(best, places[best])
    if not possible:  # it is not where it can have gone by itself: somebody has turned it
        possible = {spool for spool, place in places.items() if travel[0] <= place <= travel[1]}
    others = tuple(sorted(places[spool] for spool in possible - {best}))
    return Located(best, places[best], others or (places[best] - math.copysign(turn, places[best]),))
