"""The strain that a reference asks of the backbone, beside what the backbone bears without a permanent bend."""

import math
from collections.abc import Iterable
from typing import Any

import numpy as np

from tendond.daemon.control.safety.body import Body
from tendond.model.rod.state import RodState
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.interface import ModelRod
from tendond.model.strain.describe.configured import robot_from_section
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection

YIELD = ((150e9, 0.008, "spring steel"), (20e9, 0.06, "nitinol"))
"""Lowest Young's modulus [Pa], largest strain without a permanent bend where rod.yield_strain is not given, material.

Music wire of 1 mm: about 0.8 of a tensile strength of 2.1 GPa (EN 10270-1). Nitinol: the superelastic strain of ASTM
F2516, 6 %. Softer backbones are not judged."""

CURVATURE = slice(3, 5)
"""Columns of `RodState.levels`: curvature about x and y [1/m]."""


def yield_strain(section: RodSection) -> tuple[float | None, str]:
    """Return the strain that the backbone bears [-], and the material that was assumed; none for an unknown one."""
    if section.yield_strain is not None:
        return section.yield_strain, ""
    modulus = min(_modulus(one) for one in robot_from_section(section).sections)
    return next(((strain, material) for modulus_min, strain, material in YIELD if modulus >= modulus_min), (None, ""))


def bending_strain(section: RodSection, rod: ModelRod, states: Iterable[Any]) -> float:
    """Return the largest strain of the outermost fibre by bending, over states of a rod [-].

    Args:
        section: [rod]. rod: made from it. states: of that rod.
    """
    if isinstance(rod, GeneralRod):
        rows = Body(rod, (1.0,)).bend_rows
        return max(float(np.linalg.norm(rows @ one.strain.strain, axis=1).max()) for one in states)
    return (section.outer_radius or section.radius) * max(map(_curvature, states))


def strain_note(config: RigConfig, rod: ModelRod, states: Iterable[Any], where: str) -> tuple[str, ...]:
    """Say that a reference takes more strain than the backbone bears; empty where it does not, or where none is known.

    Args:
        config: of the rig. rod: the controller's model. states: its rests along the reference.
        where: place of the largest one, for the message: 'at the target'.
    """
    limit, material = yield_strain(config.rod)
    if limit is None or (strain := bending_strain(config.rod, rod, states)) <= limit:
        return ()
    bears = f"{material} bears; rod.yield_strain is not given" if material else "it bears by rod.yield_strain"
    return (
        f"{where} the backbone is strained by {100.0 * strain:.2g} %, more than the {100.0 * limit:.2g} % that {bears}:"
        " it may keep a bend; choose a reference that bends it less",
    )


def _curvature(state: RodState) -> float:
    """Return the largest curvature of a state of the shooting rod [1/m]."""
    return float(np.linalg.norm(state.levels[state.count % 3][:, CURVATURE], axis=1).max())


def _modulus(section: Any) -> float:
    """Young's modulus of a round wire or tube [Pa]."""
    EI, EA, radius = max(section.bending_stiffness), section.axial_stiffness, section.fibre(0.5 * section.length)
    return float(EA / (2.0 * math.pi * max(radius**2 - 2.0 * EI / EA, 1e-6 * radius**2)))
