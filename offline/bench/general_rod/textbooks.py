"""The general rod beside textbooks: each figure is the distance of the tip from a published or exact one, by length."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from tendond.model.strain import Robot, Section, StrainRod, Tendon
from tendond.model.strain.derivatives.follower import Followers
from tendond.model.strain.derivatives.linearise import Linearisation

Array = NDArray[np.float64]


ELASTICA = ((1.0, 0.30172, 0.05643), (2.0, 0.49346, 0.16064), (5.0, 0.71379, 0.38763))
"""P L^2 / EI of a dead load across the tip, deflection w / L, shortening 1 - x / L.

K. Mattiasson, "Numerical results from large deflection beam and frame problems", IJNME 17 (1981).
"""


def elastica_tip(load: float) -> tuple[float, float]:
    """Return deflection and shortening of a rod of length 1 m under a dead load across its tip, P L^2 / EI."""
    section = Section.round(1.0, 1e-3, 200e9, 7850.0, stretch_modes=0, bending_modes=6)
    rod = StrainRod(Robot((section,)))
    tip, _ = rod.tip(rod.solve_static(rod.loads(tip_force=(load * section.bending_stiffness[1], 0.0, 0.0))))
    return float(tip[0]), 1.0 - float(tip[2])


def elastica() -> float:
    """Return the largest error of `ELASTICA`."""
    return max(math.dist(elastica_tip(load), published) for load, *published in ELASTICA)


def helix() -> float:
    """Return the error of a precurved and pretwisted wire without load: a helix of two turns, in closed form."""
    curvature, twist, length = 5.0 * math.pi, 3.0, 0.8
    section = Section.round(length, 1e-3, 200e9, 7850.0, curvature=(0.0, curvature, twist))
    rod = StrainRod(Robot((section,)))
    total = math.hypot(curvature, twist)
    axis, angle = np.array([0.0, curvature, twist]) / total, total * length
    along = np.array([0.0, 0.0, 1.0])
    exact = (
        math.sin(angle) / total * along
        + (1.0 - math.cos(angle)) / total * np.cross(axis, along)
        + (length - math.sin(angle) / total) * axis * (axis @ along)
    )
    return float(np.linalg.norm(rod.tip(rod.rest())[0] - exact)) / length


BEND_ARC = 100.0 * math.pi / 4.0
BEND_TIP = (15.558, 46.892, 53.606)
"""Tip of a shooting solver, of the equations of `bend_tip` [in]."""


def bend_tip() -> tuple[float, float, float]:
    """Return the tip at 600 lb of the 45 degree bend of K.-J. Bathe and S. Bolourchi, IJNME 14 (1979) [in].

    Radius 100 in, 1 in square, E = 1e7 psi, torsion of a square 0.1406 G. In the plane, along, out of the plane.
    Published: 15.9, 47.2, 53.4; Simo & Vu-Quoc 15.79, 47.23, 53.37; Cardona & Geradin 15.55, 47.04, 53.50.
    """
    section = Section(
        BEND_ARC, (1e7 / 12.0, 1e7 / 12.0), 0.140577 * 5e6, 1e7, 1.0, 1.0, curvature=(0.0, 0.01, 0.0), bending_modes=6,
        torsion_modes=6, stretch_modes=2,
    )  # fmt: skip
    rod = StrainRod(Robot((section,)))
    state = rod.rest()
    for load in np.linspace(60.0, 600.0, 10):
        state = rod.solve_static(rod.loads(tip_force=(0.0, load, 0.0)), state)
    in_plane, out_of_plane, along = (float(one) for one in rod.tip(state)[0])
    return in_plane, along, out_of_plane


def curved_cantilever() -> float:
    """Return the error of `bend_tip`."""
    return math.dist(bend_tip(), BEND_TIP) / BEND_ARC


def heavy_column() -> float:
    """Return the relative error of the weight per length under which an upright rod buckles: 7.8373 EI / L^3.

    A. G. Greenhill (1881); S. Timoshenko and J. Gere, Theory of Elastic Stability (1961), section 2.12.
    """
    section = Section.round(0.5, 1e-3, 190e9, 7850.0, stretch_modes=0, bending_modes=5)

    def margin(part: float) -> float:
        weight = part * section.bending_stiffness[0] / (section.length**3 * section.mass_per_length)
        rod = StrainRod(Robot((section,), gravity=(0.0, 0.0, -weight)))
        return Linearisation(rod).stability(rod.rest(), rod.loads())

    low, high = 7.0, 9.0
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if margin(middle) > 0.0 else (low, middle)
    return abs(low / 7.83735 - 1.0)


REACH = 0.242
THREE = Tendon(0.1, (0.008, 0.0)), Tendon(0.18, (-0.004, 0.007)), Tendon(REACH, (-0.004, -0.007))
HELICAL, CONVERGING = Tendon.helical(REACH, 0.008, 0.5), Tendon.converging(REACH, (0.01, 0.0), (0.004, 0.003))

Routed = tuple[tuple[Tendon, ...], tuple[float, ...], tuple[float, float, float]]
ROUTED: dict[str, Routed] = {
    "converging": ((CONVERGING,), (4.0,), (0.0, 0.0, 0.0)),
    "helical": ((HELICAL,), (3.0,), (0.0, 0.0, 0.0)),
    "both with a load": ((HELICAL, CONVERGING), (2.0, 3.0), (0.1, 0.05, 0.02)),
    "ends of three sections": (THREE, (4.0, 2.0, 3.0), (0.0, 0.1, 0.0)),
}
"""Tendons, their tensions [N] and a dead force on the tip [N]."""

Tip = tuple[Array, Array]


def routed_tips(
    case: Routed, solve: Callable[..., Tip], piece: Callable[[float, tuple[float, float, float], float], object]
) -> tuple[Tip, Tip]:
    """Return position [m] and orientation of the tip with routed tendons, and those of a plain solver.

    The robot of D. C. Rucker and R. J. Webster, IEEE T-RO 27 (2011): L 242 mm, radius 0.4 mm, E 210 GPa, tendons 8 mm
    off the axis. The solver is that of the tests, tests/reference/routing.py: `solve_routing` and `Piece`.
    """
    tendons, tensions, force = case
    lengths = np.diff([0.0, *sorted({one.end for one in tendons} | {REACH})])
    sections = tuple(
        Section.round(float(one), 4e-4, 210e9, 7850.0, bending_modes=8, torsion_modes=6, stretch_modes=4)
        for one in lengths
    )
    rod = StrainRod(Robot(sections, tendons))
    state = rod.rest()
    for part in np.linspace(0.25, 1.0, 4):
        state = rod.solve_static(rod.loads(part * np.array(tensions), tip_force=part * np.array(force)), state)
    tip, one = rod.tip(state), sections[0]
    moduli = (*one.bending_stiffness, one.torsion_stiffness)
    pieces = [piece(float(part), moduli, one.axial_stiffness) for part in lengths]
    pulls = [(tension, tendon.end, tendon.at) for tension, tendon in zip(tensions, tendons, strict=True)]
    return tip, solve(pieces, pulls, force, guess=tip[0])


def routing(solve: Callable[..., Tip], piece: Callable[[float, tuple[float, float, float], float], object]) -> float:
    """Return the largest error of the tips of `ROUTED`, beside the plain solver's."""
    tips = (routed_tips(case, solve, piece) for case in ROUTED.values())
    return max(float(np.linalg.norm(ours[0] - theirs[0])) / REACH for ours, theirs in tips)


def follower() -> float:
    """Return the largest error under a transverse follower force at the tip, P L^2 / EI = 1, 4, 10.

    Seen from the tip, where force and slope are known, the elastica EI theta'' = -P cos(theta) is an initial-value
    problem: no iteration is needed (the cantilever of J. H. Argyris and S. Symeonidis, CMAME 26, 1981).
    """
    section = Section.round(1.0, 1e-3, 200e9, 7850.0, stretch_modes=0, bending_modes=8)
    rod = StrainRod(Robot((section,)))
    errors = []
    for load in (1.0, 4.0, 10.0):
        pushed = Followers(rod, [(1.0, (load * section.bending_stiffness[1], 0.0, 0.0), (0.0, 0.0, 0.0))])
        tip, _ = rod.tip(pushed.solve_static(rod.loads()))

        def slope(s: float, y: Array, load: float = load) -> list[float]:
            # from the tip on, in its frame: turn, curvature, place; the force is along x there
            return [y[1], -load * math.cos(y[0]), math.sin(y[0]), math.cos(y[0])]

        turn, _, x, z = solve_ivp(slope, (0.0, 1.0), [0.0, 0.0, 0.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]
        away, along = x * math.cos(turn) - z * math.sin(turn), x * math.sin(turn) + z * math.cos(turn)
        errors.append(math.hypot(abs(tip[0]) - abs(away), tip[2] - along))
    return max(errors)
