"""Which uniform robots need the general rod, and which swing under a law that moves the tip within a cycle."""

import math

from tendond.schemas.config.rates import damping_ratio
from tendond.schemas.config.robot import RodSection

DAMPING_MIN = 0.05
"""Damping ratio of the first mode below which steps of the shooting rod fail (docs/explanation/general-rod.md)."""

WEIGHT_MAX = 2.0
"""rho A g L^3/EI from which on steps of the shooting rod fail, or lead to another shape: of the paper's wire with
random pulls at 100 Hz none does up to 0.8 m, where it is 1.8; with 0.9 m, 2.6, tips move half a length in 10 ms."""

TIP_LOAD_MAX = 0.2
"""Largest P L^2/EI of the model's own tip body: 12 g on the paper's robot. A law in space asks for a tip that is moved
within a cycle, and its agility does not suffice for a heavy one: it then swings the arm. From runs with plant = model
at 100 Hz: they settle at 0.22 to 0.25 and swing at 0.33 to 0.35, with E -30 %, as it is, and +50 %. On the general
rod the paper's robot settles with 12 g at targets 0.05 to 0.34 m across; with 20 g it whirls at those up to 0.15 m, and
settles at those from 0.2 m on. A law's agility is less beside the tensions of a robot that needs larger ones: with
tendons at half the distance it settles with 3 g, and swings with 4.2 g on the shooting rod, 12 g on either; so the
bound falls with the square of EI/(L r) beyond the paper's robot's. The tests hold both sides, of both rods."""

PERIODS_MIN = 15.0
"""Cycles in sqrt(rho A L^4/EI), below which the bound falls with the third power of their number: from the same runs at
50, 70, 100 and 250 Hz, which swing with 2, 10, 20 and 30 g and settle with none, 5, 15 and 25 g."""

NEAR_TIP = 0.999
"""Part of the backbone's length from which on a tendon counts as ending at the tip."""

PLANE = 5.0
"""Tip mass that the paper's laws bear, of that bound. From runs with an arm of 0.25 m of nitinol, 1.2 mm thick, tendons
at 8 mm. At 100 Hz the bound is 0.9 g: with 1 g it settles at damping ratios of 0.1 and more, with 2 and 4 g at 0.6
alone. At 150 Hz it is 3.2 g, and it settles with 4 g and swings with 15 g; at 250 Hz, 10 g, it settles with both."""

DAMPED, CYCLES = 0.03, 7.0
"""B/EI [s] and cycles in sqrt(rho A L^4/EI) from which on they bear any mass: the paper's robot has 0.035 s and 15
cycles at 100 Hz, and settles with 50 g at 50 Hz too; the nitinol arm, which swings, has 6.8 cycles at 100 Hz."""

FAST_DAMPING_MIN = 0.07
"""Damping ratio of the first mode that the paper's laws need on an arm with fewer of those cycles. From runs at 100 Hz,
to a turn of the tip by 45 degrees: an arm of 0.2 m of nitinol, 1.4 mm thick, 4.3 g, which has 5.8 cycles, ends in a
limit cycle at 0.05, and settles at 0.06, 0.07, 0.1 and 0.15 (tests/unit/config/test_default_law.py)."""

EARTH = 9.81
"""Gravity, for a mass of robots that lie across it or not [m/s^2]."""


def sags(rod: RodSection) -> bool:
    """Return whether a uniform robot is so soft beside its own weight that the shooting rod does not suit it."""
    stiffness, length, mass, _ = _measures(rod)
    return mass * math.hypot(*rod.base_gravity) * length**2 > WEIGHT_MAX * stiffness


def mass_within_cycle(stiffness: float, length: float, mass: float, arm: float, period: float) -> float:
    """Return the largest mass on the tip for a law that moves it within a cycle [kg].

    Args:
        stiffness: EI [N m^2]. length: L [m]. mass: of the backbone and all on it [kg].
        arm: largest distance of a tendon from the axis, r [m]. period: of the cycle [s].
    """
    rod_time = math.sqrt(mass * length**3 / stiffness)
    rate, agility = rod_time / (PERIODS_MIN * period), _PAPER * length * arm / stiffness
    return TIP_LOAD_MAX * stiffness / (EARTH * length**2) * min(1.0, rate**3, agility**2)


def swings(rod: RodSection, period: float) -> str:
    """Return why the arm would swing under a law that moves its tip within a cycle; empty where it does not.

    A configuration that names no law then has one that moves the arm along its rests. Such a robot has several
    sections or one that changes along it, a tendon that ends before the tip, light damping, or a heavy tip.

    Args:
        rod: [rod]. period: of the cycle [s].
    """
    if len(rod.section) > 1:
        return f"it has {len(rod.section)} sections"
    if any(one.end is not None and one.end < NEAR_TIP * rod.backbone_length for one in rod.tendon):
        return "a tendon ends before its tip"
    if rod.section and rod.not_uniform:
        return rod.not_uniform
    ratio = damping_ratio(rod)
    stiffness, length, mass, arm = _measures(rod)
    cycles = math.sqrt(mass * length**3 / stiffness) / period
    least = DAMPING_MIN if cycles >= CYCLES else FAST_DAMPING_MIN
    if ratio < least:
        return f"its first mode has a damping ratio of {100.0 * ratio:.2g} %, below {100.0 * least:g} %"
    if rod.bending_damping[0] >= DAMPED * stiffness and cycles >= CYCLES:
        return ""
    most = PLANE * mass_within_cycle(stiffness, length, mass, arm, period)
    if rod.tip_mass > most:
        return f"its tip carries {1e3 * rod.tip_mass:.3g} g, and the paper's laws bear {1e3 * most:.2g} g"
    return ""


def _measures(rod: RodSection) -> tuple[float, float, float, float]:
    """Return EI, L, mass and r of a uniform robot."""
    stiffness = rod.youngs_modulus * math.pi / 4.0 * rod.radius**4
    mass = rod.density * math.pi * rod.radius**2 * rod.length
    return stiffness, rod.length, mass, max(max(math.hypot(x, y) for x, y in rod.tendon_positions), rod.radius)


_STIFFNESS, _LENGTH, _, _ARM = _measures(RodSection())
_PAPER = _STIFFNESS / (_LENGTH * _ARM)
"""EI/(L r) of the paper's robot [N]."""
