"""A camera as witness of a calibration: what the tip's lean says of id, sign and radius."""

import math

import numpy as np
import pytest

from tendond.drivers.dynamixel.tools.calibrate import camera_objection
from tendond.drivers.dynamixel.tools.camera import bend_of, shortened
from tendond.model.numerics.rotation import quaternion
from tendond.model.rods.selection import rod_from_section
from tendond.schemas.config.robot import RodSection

POSITIONS = ((0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02))


def leaning(angle: float, direction: float) -> tuple[float, float, float, float]:
    """Quaternion of a tip that leans by an angle towards a direction [rad]."""
    axis = (-math.sin(direction), math.cos(direction), 0.0)
    turned = math.sin(0.5 * angle)
    return math.cos(0.5 * angle), turned * axis[0], turned * axis[1], turned * axis[2]


@pytest.mark.parametrize("angle", [0.0, 0.2, 1.5, 3.0])
@pytest.mark.parametrize("direction", [0.0, 0.7, -2.0])
def test_the_bend_of_a_tip_is_its_lean_and_where_to(angle: float, direction: float) -> None:
    assert bend_of(leaning(angle, direction)) == pytest.approx(
        (angle * math.cos(direction), angle * math.sin(direction)), abs=1e-9
    )


def test_the_rods_own_statics_shorten_a_tendon_by_its_distance_times_the_bend() -> None:
    """The Cosserat rod, stiff but not inextensible, pulled by one tendon without gravity, is the reference."""
    rod = rod_from_section(RodSection(gravity=(0.0, 0.0, 0.0)), 0.01)
    tensions = np.zeros(len(rod.parameters.tendon_positions))
    rest = rod.solve_static(tensions)
    tensions[0] = 8.0
    bent = rod.solve_static(tensions)
    before, after = (bend_of(quaternion(rod.tip(one).rotation)) for one in (rest, bent))
    travel = rod.displacements(bent)[0] - rod.displacements(rest)[0]
    assert travel > 0.003
    assert shortened(rod.parameters.tendon_positions[0], before, after) == pytest.approx(travel, rel=0.02)


@pytest.mark.parametrize(
    ("displacement", "bend", "objection"),
    [
        (0.004, (0.2, 0.0), ""),
        (0.004, (0.16, 0.03), ""),  # a stretched tendon, and one beside the axis
        (0.004, (0.1, 0.0), "the camera measured 2.0 mm: is servo.spool_radius correct"),
        (0.004, (0.4, 0.0), "the camera measured 8.0 mm: is servo.spool_radius correct"),
        (0.004, (0.0, 0.2), "the tip bent towards tendon 1: is the servo's id, or its sign, correct?"),
        (0.004, (-0.2, 0.0), "the tip bent towards tendon 2: is the servo's id, or its sign, correct?"),
        (0.004, (0.0, 0.0), "the camera measured 0.0 mm"),
    ],
)
def test_a_swapped_id_a_wrong_sign_and_a_wrong_radius_are_named(
    displacement: float, bend: tuple[float, float], objection: str
) -> None:
    found = camera_objection(0, POSITIONS, displacement, (0.0, 0.0), bend)
    assert objection in found
    assert bool(found) is bool(objection)
