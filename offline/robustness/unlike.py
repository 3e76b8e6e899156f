"""Plants unlike the model, of any robot: factors on its properties, elastic tendons, and loads that suit its size."""

from typing import Any

from tendond.model.estimation.margin import default_tip_mass
from tendond.model.rod.parameters import RodParameters
from tendond.schemas.assumed_rig import TENDON_STIFFNESS
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.scale import RodScale

PAPERS_TIP_MASS = 0.1
"""Mass on the paper's robot that `default_tip_mass` stands for [kg], to two digits."""


def unlike(rod: RodSection, stiffness: float = 1.0, damping: float = 1.0, drag: float = 1.0) -> RodSection:
    """Return [rod] with factors on Young's modulus, damping and drag: of its keys, or of all its sections."""
    if rod.not_uniform:
        scale = rod.scale or RodScale()
        factors = {"stiffness": stiffness, "damping": damping, "drag": drag}
        changed: dict[str, Any] = {name: getattr(scale, name) * factor for name, factor in factors.items()}
        return rod.model_copy(update={"scale": scale.model_copy(update=changed)})
    return rod.model_copy(
        update={
            "youngs_modulus": rod.youngs_modulus * stiffness,
            "bending_damping": tuple(value * damping for value in rod.bending_damping),
            "drag": tuple(value * drag for value in rod.drag),
        }
    )


def with_elastic_tendons(rod: RodSection) -> RodSection:
    """Return [rod] with the stiffness of assumed tendons where none is given, so that displacement can drive it."""
    if not rod.tendon:
        return rod.model_copy(update={"tendon_stiffness": rod.tendon_stiffness or TENDON_STIFFNESS})
    tendons = tuple(one.model_copy(update={"stiffness": one.stiffness or TENDON_STIFFNESS}) for one in rod.tendon)
    return rod.model_copy(update={"tendon": tendons})


def load_factor(rod: RodParameters) -> float:
    """Return the factor on masses and forces that have the effect on this robot that they have on the paper's [-]."""
    return float(f"{default_tip_mass(rod) / PAPERS_TIP_MASS:.2g}")
