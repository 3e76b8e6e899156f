"""The equilibria of a target in the bending plane: which there are, which is meant, and what keeps the tip from them.

Under one tendon the resting tip runs along a curve; a target that names one coordinate, or an angle, may be met by it
several times. Each crossing is an equilibrium, numbered by the tension, and so by the bend.
"""

import math
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import share
from tendond.daemon.errors import TargetError
from tendond.model.errors import ConvergenceError
from tendond.model.rod.static_curve import StaticCurve
from tendond.model.rods.interface import ModelRod
from tendond.schemas import paper_robot
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

GROWTH = 8
"""Equilibria from no tension to that at the target, each the start of the next: chosen, as a curve has 161 up to
limits.tension_max."""


def default_branch(config: RigConfig) -> str:
    """Return the branch of a target that names none: the least bent; the paper's of its robot."""
    rod = config.rod
    papers = not rod.section and rod.length == paper_robot.LENGTH and rod.radius == paper_robot.RADIUS
    return "above_135" if papers or config.control.rules == 1 else "below_135"


def selected(config: RigConfig, section: ReferenceSection, found: Array, asked: str) -> int:
    """Return the index of the crossing that is meant among those found.

    Args:
        config: configuration of the rig.
        section: [reference].
        found: arc lengths of the crossings on the curve [m], increasing, not empty.
        asked: target, for messages.

    Raises:
        TargetError: there is none of that number.
    """
    branch = default_branch(config) if section.branch is None else section.branch
    if isinstance(branch, int):
        if branch > len(found):
            raise TargetError(
                f"reference.branch = {branch}: the tip rests in {len(found)} shape{'s' if len(found) > 1 else ''} with "
                f"{asked}: give 1 to {len(found)}"
            )
        return branch - 1
    return 0 if branch == "below_135" else len(found) - 1


def folded_note(section: ReferenceSection, curve: StaticCurve, found: Array, index: int, asked: str) -> tuple[str, ...]:
    """Say that a target is behind the fold, where it has less bent shapes; empty where it is the least bent."""
    if index == 0:
        return ()
    first, here = (math.degrees(abs(tip_angle(curve, float(found[k])))) for k in (0, index))
    default = ", by the default of reference.branch" if section.branch is None else ""
    return (
        f"reference.{asked}: of {len(found)} resting shapes the folded one, bent by {here:.0f} degrees, is the target"
        f"{default}; branch = 1 is bent by {first:.0f} degrees",
    )


def plane_objection(config: RigConfig, rod: ModelRod, state: Any, axes: tuple[int, int], tolerance: float) -> str:
    """Say by how much the tip at rest is beside the bending plane, which the law cannot change; empty if it is not.

    Args:
        config: configuration of the rig.
        rod: the controller's model. state: its rest at the target.
        axes: of the bending plane.
        tolerance: distance from the plane that is none [m].
    """
    beside = float(rod.tip(state).position[3 - sum(axes)])  # the coordinate out of the plane
    if abs(beside) <= tolerance:
        return ""
    control, axis = config.control, "xyz"[3 - sum(axes)]
    pulled = f"tendon {control.agonist}" if control.antagonist is None else (
        f"the tendons {control.agonist} and {control.antagonist}"
    )  # fmt: skip
    return (
        f"reference: at the target {pulled} and the weight hold the tip {1e3 * abs(beside):.1f} mm out of the plane "
        f"'{control.plane}', towards {'+' if beside > 0.0 else '-'}{axis}, and a law in the plane cannot move it back: "
        "turn rod.tendon_positions or rod.base, choose other tendons, or the law sensitivity"
    )


def tip_angle(curve: StaticCurve, arc: float) -> float:
    """Return the angle of the resting tip at an arc length [rad]."""
    return float(np.interp(arc, curve.arc, curve.angle))


def rest_at(config: RigConfig, rod: ModelRod, curve: StaticCurve, arc: float) -> Any:
    """Return the state of the rod at rest at an arc length of its curve [m], the antagonist pretensioned."""
    control, count = config.control, rod.parameters.tendon_count
    pair_tension = 0.0 if control.antagonist is None else config.pretension.antagonist
    pulled = share(count, control.agonist, control.antagonist, curve.tension_at(arc), pair_tension)
    state = rod.solve_static(np.zeros(count))
    with suppress(ConvergenceError):  # what it has no further equilibrium for is the last one's
        for part in np.linspace(0.0, 1.0, GROWTH + 1)[1:]:
            state = rod.solve_static(part * pulled, start=state)
    return state
