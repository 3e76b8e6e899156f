"""The round wire that sections amount to, by which limits are derived from a robot."""

import math

import pytest

from tendond.schemas.config.rates import damping_ratio, natural_frequency, own_tension_rate
from tendond.schemas.config.rig import check_config
from tendond.schemas.config.robot import RodSection


def rod(**keys: object) -> RodSection:
    return check_config({"rod": keys}, "test").rod


WIRE = {"radius": 7e-4, "youngs_modulus": 54e9, "density": 6450.0}


def test_sections_of_one_wire_are_that_wire_with_its_disks_spread() -> None:
    two = rod(section=[{**WIRE, "length": 0.1}, {**WIRE, "length": 0.3, "disk_number": 4, "disk_mass": 1e-3}])
    assert (two.length, two.radius) == pytest.approx((0.4, 7e-4))
    assert two.youngs_modulus == pytest.approx(54e9)
    assert two.density == pytest.approx(6450.0 + 4e-3 / (0.4 * math.pi * 7e-4**2))


def test_a_taper_has_its_mean_compliance_and_mass() -> None:
    tapered = rod(section=[{**WIRE, "length": 0.2, "radius": [[0.0, 1e-3], [0.2, 5e-4]]}])
    slope = -5e-4 / 0.2  # of the radius: the integral of r^-4 is (r1^-3 - r0^-3) / (-3 slope)
    compliance = (5e-4**-3 - 1e-3**-3) / (-3.0 * slope) / (54e9 * math.pi / 4.0)
    own = tapered.youngs_modulus * math.pi / 4.0 * tapered.radius**4
    assert 0.2 / own == pytest.approx(compliance, rel=5e-3)
    volume = math.pi * 0.2 * (1e-6 + 5e-7 + 2.5e-7) / 3.0
    assert tapered.density * math.pi * tapered.radius**2 * 0.2 == pytest.approx(6450.0 * volume, rel=1e-3)


def test_limits_of_a_robot_with_sections_are_its_own_not_the_papers() -> None:
    places = [[0.01, 0.0], [-0.01, 0.0]]
    whole = rod(**WIRE, length=0.2, tendon_positions=places)
    parts = rod(
        section=[{**WIRE, "length": 0.1}, {**WIRE, "length": 0.1}], tendon=[{"position": place} for place in places]
    )
    assert natural_frequency(parts) == pytest.approx(natural_frequency(whole))
    assert own_tension_rate(parts) == pytest.approx(own_tension_rate(whole))


def test_the_damping_ratio_is_the_first_modes() -> None:
    assert damping_ratio(rod(preset="nitinol")) == pytest.approx(0.02, rel=2e-3)
    assert damping_ratio(rod(preset="nitinol", tip_mass=0.05, damping_ratio=0.1)) == pytest.approx(0.1, rel=1e-2)
    assert damping_ratio(rod()) == pytest.approx(0.63, abs=0.01)


def test_the_mass_on_the_tip_is_known_to_other_tables() -> None:
    assert rod(section=[{**WIRE, "length": 0.2}, {**WIRE, "length": 0.2}], tip={"mass": 0.03}).tip_mass == 0.03
