"""Whole turn of a servo, for the driver and every tool.

A servo counts its turns while it has power, from its position at power-up, so one reported position corresponds to
several displacements, a turn of the spool apart. The last known displacement decides: without torque the tendon can
only have moved from there towards its zero, because the robot straightens, and not beyond.
"""

import math
from dataclasses import dataclass

from tendond.drivers.dynamixel.calibration import TendonCalibration
from tendond.drivers.dynamixel.spool import Spool
from tendond.schemas.config.servo import ServoSection

TURN_MARGIN = 0.125
"""Fraction of a turn by which a tendon may be beyond its last known place, which is written with a delay. On a spool of
15 mm it is the travel of 0.14 s at 85 mm/s."""


@dataclass(frozen=True)
class Located:
    """Spool with its most likely turn.

    Attributes:
        spool: with that turn.
        displacement: displacement of the tendon [m].
        others: other possible displacements [m]; empty where the turn is certain.
    """

    spool: Spool
    displacement: float
    others: tuple[float, ...] = ()

    @property
    def turn(self) -> float:
        """Displacement of one turn [m]."""
        return 2.0 * math.pi * self.spool.calibration.spool_radius

    @property
    def certain(self) -> bool:
        """True where only one turn is possible."""
        return not self.others

    @property
    def doubt(self) -> str:
        """Possible displacements, in words; empty where there is only one."""
        if self.certain:
            return ""
        places = " or ".join(f"{place * 1e3:.1f}" for place in sorted((self.displacement, *self.others), reverse=True))
        return f"stands at {places} mm: its servo has lost its turns, and it is unknown which"


def locate(section: ServoSection, tendon: TendonCalibration, position: int, last: float | None) -> Located:
    """Find the turn of a servo.

    Args:
        section: [servo].
        tendon: its calibration.
        position: reported [ticks].
        last: last known displacement of the tendon [m]; none where unknown.
    """
    nearest = round((position - tendon.zero) / tendon.ticks_per_turn)
    turn = 2.0 * math.pi * tendon.spool_radius
    reach = math.ceil(max(section.displacement_max, -section.displacement_min) / turn) + 1
    places = {(spool := Spool(tendon, nearest + k)): spool.displacement(position) for k in range(-reach, reach + 1)}
    wanted = 0.0 if last is None else last
    best = min(places, key=lambda spool: abs(places[spool] - wanted))
    if last is None and abs(places[best]) <= section.home_window:
        return Located(best, places[best])  # by the configuration, no other turn is within the travel
    further = TURN_MARGIN * turn
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
    if not possible:  # it cannot have moved there by itself: somebody has turned it
        possible = {spool for spool, place in places.items() if travel[0] <= place <= travel[1]}
    others = tuple(sorted(places[spool] for spool in possible - {best}))
    return Located(best, places[best], others or (places[best] - math.copysign(turn, places[best]),))
