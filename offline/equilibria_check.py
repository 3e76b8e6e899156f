"""The equilibria of a target in the bending plane, as figures: bend, tension, stability, margin and strain of each."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from tendond.daemon.control.actuation import share
from tendond.daemon.control.reference.planar import PlanarReference
from tendond.daemon.control.reference.strain import yield_strain
from tendond.daemon.control.selection import Selection
from tendond.daemon.errors import DaemonError
from tendond.model.errors import ModelError
from tendond.model.rod.static_curve import StaticCurve
from tendond.model.rods.selection import model_rod
from tendond.model.strain import StrainRod
from tendond.model.strain.analysis.frames import bend, strength
from tendond.model.strain.describe.configured import robot_from_section
from tendond.schemas.config.rig import RigConfig

GROWTH = 8
"""Equilibria from no tension to an equilibrium's, each the start of the next. Chosen."""

SAME = 1e-6
"""Distance along the curve, of its length, below which an equilibrium is the target [-]."""


@dataclass(frozen=True)
class Equilibrium:
    """A resting shape that meets the target, of the general rod.

    Attributes:
        number: by the bend, as reference.branch counts. target: true for the one that is meant.
        bend: of the whole backbone [rad]. tension: of the agonist [N]. margin: of limits.tension_max to that [N].
        stability: smallest eigenvalue of the tangent stiffness, of the unloaded robot's [-]; negative: unstable.
        strain: largest of any fibre [-].
    """

    number: int
    target: bool
    bend: float
    tension: float
    margin: float
    stability: float
    strain: float


def equilibria(config: RigConfig) -> list[Equilibrium]:
    """Return the equilibria of a target; empty for samples, in space, and for one that the curve does not meet.

    Raises:
        DaemonError: the law or the reference cannot be used.
        ModelError: a robot that cannot be, or that has no equilibrium.
    """
    config = config.with_own_rates()
    reference = Selection.from_config(config, model_rod(config)).reference
    if not isinstance(reference, PlanarReference) or reference.arc is None:
        return []
    curve, arc = reference.curve, reference.arc
    rod = StrainRod(robot_from_section(config.rod), config.loop.period)
    arcs = _crossings(config, curve, arc)
    return [
        _at(config, rod, curve.tension_at(one), number, target=abs(one - arc) <= SAME * curve.length)
        for number, one in enumerate(arcs, 1)
    ]


def _crossings(config: RigConfig, curve: StaticCurve, arc: float) -> list[float]:
    """Return the arc lengths that meet the target [m]; of a position, which has one, its own."""
    name = config.reference.target_name
    if name == "position":
        return [arc]
    if name == "across":
        return [float(one) for one in curve.where_across(float(curve.at(arc)[0][0]))]
    return [float(one) for one in curve.where_angle(float(np.interp(arc, curve.arc, curve.angle)))]


def _at(config: RigConfig, rod: StrainRod, tension: float, number: int, *, target: bool) -> Equilibrium:
    control = config.control
    pair = 0.0 if control.antagonist is None else config.pretension.antagonist
    pulled = share(len(rod.robot.tendons), control.agonist, control.antagonist, tension, pair)
    state = rod.solve_static(rod.loads())
    for part in np.linspace(0.0, 1.0, GROWTH + 1)[1:]:
        state = rod.solve_static(rod.loads(part * pulled), state)
    return Equilibrium(
        number=number,
        target=target,
        bend=bend(rod, state),
        tension=tension,
        margin=config.limits.tension_max - tension,
        stability=rod.stability(state, rod.loads(pulled)),
        strain=float(strength(rod, state).strain.max()),
    )


def equilibrium_lines(config: RigConfig) -> Iterator[str]:
    """Describe the equilibria of a target, a line each; none where law or reference cannot be used."""
    try:
        found = equilibria(config)
    except (DaemonError, ModelError):
        return
    limit, _ = yield_strain(config.rod)
    for one in found:
        bears = (
            "" if limit is None or one.strain <= limit else f", beyond the {100.0 * limit:.2g} % that the wire bears"
        )
        yield (
            f"equilibrium {one.number} of {len(found)}{' (the target)' if one.target else ''}: bent by "
            f"{math.degrees(one.bend):.0f} degrees, {one.tension:.3g} N ({one.margin:.3g} N below limits.tension_max), "
            f"smallest stiffness {one.stability:.2g} of the unloaded robot's"
            f"{'' if one.stability > 0.0 else ' (UNSTABLE)'}, strain {100.0 * one.strain:.2g} %{bears}"
        )
