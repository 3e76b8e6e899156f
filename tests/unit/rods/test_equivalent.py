"""The uniform rod that stands for a robot: itself where it is one; elsewhere its compliance, mode and arms."""

import math

import numpy as np
import pytest

from tendond.model.errors import ParameterError
from tendond.model.rods.equivalent import arm_stiffness, equivalent_rod
from tendond.model.rods.selection import rod_from_section
from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tendond.model.strain.analysis.modes import natural_modes
from tendond.schemas.config.rig import check_config

TAPERED = Robot(
    sections=(
        Section.tapered(0.2, [(0.0, 2e-3), (0.2, 1e-3)], 60e9, 6450.0, bending_damping=(1e-5, 1e-5, 1e-5)),
        Section.round(0.2, 1e-3, 60e9, 6450.0, bending_damping=(1e-5, 1e-5, 1e-5)),
    ),
    tendons=(Tendon(0.2, (0.01, 0.0)), Tendon.converging(0.4, (0.0, 0.02), (0.0, 0.005)), Tendon(0.4, (-0.01, 0.0))),
    bodies=(Body(0.4, 0.01),),
)


@pytest.mark.parametrize("preset", ["paper", "nitinol", "rucker-webster-2011", "till-2019"])
def test_a_uniform_robot_stands_for_itself(preset: str) -> None:
    section = check_config({"rod": {"preset": preset}}, "test").rod
    own, found = rod_from_section(section, 0.01).parameters, equivalent_rod(StrainRod.from_config(section))
    assert found.length == own.length
    assert found.bending_stiffness == pytest.approx(own.bending_stiffness, rel=1e-5)
    assert found.mass_per_length == pytest.approx(own.mass_per_length, rel=2e-3)
    assert found.bending_damping[0] == pytest.approx(own.bending_damping[0], rel=1e-5)
    assert found.gravity == own.gravity
    np.testing.assert_allclose(found.tendon_positions, own.tendon_positions, atol=1e-8)


def test_of_an_uneven_robot_compliance_first_mode_and_motion_by_tendons_are_the_same() -> None:
    rod = StrainRod(TAPERED)
    found, rest = equivalent_rod(rod), rod.rest()
    small = rod.tip(rod.solve_static(rod.loads(tip_force=(1e-4, 0.0, 0.0))))[0][0]
    assert 1e-4 * found.length**3 / (3.0 * found.bending_stiffness) == pytest.approx(small, rel=1e-4)
    mode = natural_modes(rod, rest, rod.loads(), 1)
    carried = found.tip_mass + 0.24267 * found.mass_per_length * found.length
    omega = math.sqrt(3.0 * found.bending_stiffness / found.length**3 / carried)
    assert omega == pytest.approx(2.0 * math.pi * mode.frequency[0], rel=1e-3)
    assert 0.5 * omega * found.bending_damping[0] / found.bending_stiffness == pytest.approx(
        mode.damping_ratio[0], rel=1e-3
    )
    for index, (x, y) in enumerate(found.tendon_positions):
        pull = np.zeros(3)
        pull[index] = 1e-3
        moved = rod.tip(rod.solve_static(rod.loads(pull)))[0]
        factor = 1e-3 * found.length**2 / (2.0 * found.bending_stiffness)
        np.testing.assert_allclose(moved[:2], (factor * x, factor * y), atol=1e-4 * abs(factor * 0.01))


def test_equal_parts_of_the_compliance_are_short_where_the_robot_is_thin() -> None:
    stiffness, share, places = arm_stiffness(TAPERED)
    exact = np.trapezoid(1.0 / (60e9 * math.pi / 4.0 * np.linspace(2e-3, 1e-3, 20001) ** 4), dx=0.2 / 20000)
    exact += 0.2 / (60e9 * math.pi / 4.0 * 1e-12)
    assert stiffness == pytest.approx(0.4 / exact, rel=1e-3)
    assert (share[0], share[-1], places[-1]) == (0.0, 1.0, 0.4)
    assert np.interp(0.2, places, share) < 0.35


def test_a_robot_without_tendons_has_none() -> None:
    with pytest.raises(ParameterError, match="at least one tendon"):
        equivalent_rod(StrainRod(Robot((Section.round(0.4, 1e-3, 60e9, 6450.0),))))
