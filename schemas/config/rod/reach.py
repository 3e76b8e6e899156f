"""What a robot's tendons reach: whether one ends before the tip, and whether they bend the arm to every side."""

import math

from tendond.schemas.config.robot import RodSection

NEAR_TIP = 0.999
"""Part of the backbone's length from which on a tendon counts as ending at the tip."""


def ends_early(rod: RodSection, index: int) -> bool:
    """Return true if a tendon ends before the tip.

    Args:
        rod: [rod]. index: of the tendon; one that does not exist ends nowhere.
    """
    if index >= len(rod.tendon):
        return False
    end = rod.tendon[index].end
    return end is not None and end < NEAR_TIP * rod.backbone_length


def surround(rod: RodSection) -> bool:
    """Return true if the tendons bend the arm to every side: no two neighbours half a turn or more apart."""
    angles = sorted(math.atan2(y, x) for x, y in rod.tendon_positions if math.hypot(x, y) > 0.0)
    if len(angles) < 3:
        return False
    gaps = [after - before for before, after in zip(angles, [*angles[1:], angles[0] + 2.0 * math.pi], strict=True)]
    return max(gaps) < math.pi - 1e-9


def default_law(rod: RodSection, agonist: int) -> str:
    """Return the law of a configuration that names none.

    Backstepping, the paper's, pulls one tendon in the bending plane. Where that tendon ends before the tip and the
    others can bend the arm to every side, it is `sensitivity`, which pulls all of them.

    Args:
        rod: [rod]. agonist: index of the tendon that a law in the plane pulls.
    """
    return "sensitivity" if ends_early(rod, agonist) and surround(rod) else "backstepping"
