"""Robots and loads of the derivatives' tests."""

from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tendond.model.strain.stepping.scratch import Loads

TOOL = Body(0.4, 0.05, (1e-5, 2e-5, 1.5e-5), (0.01, 0.0, 0.02))


def two_sections(damping: float = 1e-3) -> Robot:
    """Precurved halves, a helical tendon and one that ends in the middle, a tool off the axis, gravity aslant."""
    half = Section.round(
        0.2, 1e-3, 190e9, 8000.0, torsion_modes=2, bending_modes=3, curvature=(1.0, -3.0, 4.0), drag=(0.1,) * 3,
        bending_damping=(damping,) * 3,
    )  # fmt: skip
    tendons = (Tendon.helical(0.4, 0.008, 0.5), Tendon(0.2, (0.01, 0.002)))
    return Robot((half, half), tendons, (TOOL, Body(0.2, 0.01)), (1.0, -9.0, 2.0))


def sheared() -> Robot:
    """An undamped nylon rod whose first section shears and whose second does not even twist, with a body at its tip."""
    first = Section.round(0.2, 2e-3, 2e9, 1100.0, bending_modes=2, shear_modes=1, shear_stiffness=1e4)
    second = Section.round(0.15, 2e-3, 2e9, 1100.0, bending_modes=3, torsion_modes=0)
    tendons = (Tendon.helical(0.35, 0.006, 0.4), Tendon.converging(0.2, (0.01, 0.0), (0.006, 0.004)))
    return Robot((first, second), tendons, (Body(0.35, 0.01, offset=(0.0, 0.004, 0.01)),), (0.0, -9.81, 0.0))


def tugged(rod: StrainRod, k: int) -> Loads:
    return rod.loads([0.5 + 0.1 * k, 0.4])


def pulled(rod: StrainRod, k: int) -> Loads:
    return rod.loads([5.0 + 2.0 * k, 4.0, 1.0, 1.0])


def pushed(rod: StrainRod, k: int) -> Loads:
    return rod.loads(
        [8.0 + 2.0 * k, 3.0], tip_force=(0.1 * k, 0.2, 0.1), wrenches=[(0.2, (0.1, 0.0, 0.2), (0.01, 0.02, 0.01))]
    )


def driven(rod: StrainRod, k: int) -> Loads:
    return rod.loads(displacement=[3e-3 + 4e-4 * k, 2e-3 + 2e-4 * k, -9e-3, -9e-3])
