"""The filter that a configuration asks for."""

import math
from typing import NamedTuple

import numpy as np

from tendond.daemon.control.safety.barrier import Barrier
from tendond.daemon.control.safety.body import Body
from tendond.daemon.control.safety.constraints import STRAIN, Constraints
from tendond.daemon.control.safety.geometry import Surfaces, surfaces_of
from tendond.daemon.control.safety.horizon import Horizon
from tendond.daemon.errors import SafetyError
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.interface import ModelRod
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.safety.section import SafetySection

FREQUENCY_MIN = 0.02
"""Frequency below which a mode is looked ahead for no further [Hz]: 50 s and the later samples."""


class Watched(NamedTuple):
    """What [safety] watches: its section, places of the body, surfaces, largest strain [-], radius of the body [m]."""

    section: SafetySection
    body: Body
    surfaces: Surfaces
    strain_max: float | None
    radius: float


def watched_by(config: RigConfig, rod: ModelRod) -> Watched | None:
    """Return what [safety] watches, for the filter and for laws that plan; none where there is nothing to keep."""
    section = config.safety
    if section is None or not isinstance(rod, GeneralRod):
        return None
    strain_max = config.rod.yield_strain if section.strain_max is None else section.strain_max
    body = Body(rod, section.stations)
    radius = section.body_radius
    if radius is None:
        radius = max(math.hypot(x, y) for x, y in config.rod.tendon_positions)
    surfaces = surfaces_of(section, len(body.parts), radius)
    if surfaces.count == 0 and strain_max is None:
        return None
    return Watched(section, body, surfaces, strain_max, radius)


def configured_barrier(config: RigConfig, rod: ModelRod, lag_factor: float) -> Barrier | None:
    """Return the filter of [safety]; none where there is nothing to keep.

    Args:
        config: of the rig. rod: the model. lag_factor: of the actuators in a cycle [-].

    Raises:
        SafetyError: the resting arm breaks a constraint.
        ConvergenceError: the rod has no equilibrium.
    """
    watched = watched_by(config, rod)
    if watched is None or not isinstance(rod, GeneralRod):
        return None
    section, body, surfaces, strain_max, radius = watched
    n, period = len(rod.robot.tendons), config.loop.period
    rest = rod.solve_static(np.zeros(n))
    slowest = 1.0 / max(float(rod.strain_rod.frequencies(rest.strain, rod.loads(None))[0]), FREQUENCY_MIN)
    horizon = Horizon(slowest, period, lag_factor)
    constraints = Constraints(section, surfaces, strain_max, len(body.bend_rows), horizon.spacing)
    gamma = 1.0 - math.exp(-period / section.approach_time) if section.approach_time > 0.0 else 1.0
    barrier = Barrier(rod, body, constraints, horizon, gamma)
    barrier.warm_up(rest)
    constraint, distance = barrier.at_rest(rest.strain)
    if distance < 0.0:
        amount = f"{-distance:.2g} beyond" if constraint == STRAIN else f"{-distance * 1e3:.3g} mm too near to"
        raise SafetyError(
            f"safety: the resting arm is {amount} '{constraint}', with body_radius = {radius:.3g} m and margin = "
            f"{section.margin:g} m: move the constraint away from it, or lower them"
        )
    return barrier


def target_remark(barrier: Barrier | None, target: tuple[float, float, float]) -> str:
    """Say that the tip's target [m] lies where the filter does not let the tip go; empty if it does not."""
    if barrier is None:
        return ""
    constraint, distance = barrier.at_tip(np.array(target))
    if distance >= 0.0:
        return ""
    x, y, z = target
    return (
        f"the target ({x:.4f}, {y:.4f}, {z:.4f}) m is {-distance * 1e3:.0f} mm beyond what [safety] allows at "
        f"'{constraint}': the tip stops before it"
    )
