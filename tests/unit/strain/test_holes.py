"""Tendons that turn in holes only: the capstan from hole to hole in closed form, and the route that they stand for."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain import Robot, Section, StrainRod, Tendon
from tendond.model.strain.analysis.balance import balance_of
from tendond.model.strain.describe.configured import robot_from_section
from tendond.model.strain.friction.along import tension_along
from tendond.schemas.config.robot import RodSection

LENGTH, ARM, SPRING, MU = 0.5, 0.02, 2e4, 0.3
STIFFNESS = 190e9 * math.pi * 1e-12 / 4.0
BEND = 0.5 * math.pi
SECTION = Section.round(LENGTH, 1e-3, 190e9, 7850.0, torsion_modes=0, stretch_modes=0)


def holes(count: int) -> tuple[float, ...]:
    """Holes of equal disks, the last one at the tip."""
    return tuple(LENGTH * (index + 1) / count for index in range(count))


def arc(count: int, friction: float = MU) -> StrainRod:
    """A stiff quarter circle with `count` disks; none: a sheath."""
    section = replace(
        Section.round(LENGTH, 0.03, 190e9, 7850.0, torsion_modes=0, stretch_modes=0),
        curvature=(0.0, BEND / LENGTH, 0.0),
    )
    tendon = Tendon(LENGTH, (ARM, 0.0), SPRING, friction, holes=holes(count))
    return StrainRod(Robot((section,), (tendon,)))


def along(rod: StrainRod, *pulls: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return places and tensions along the tendon after its servo has pulled with these forces, one after the other."""
    state = None
    for pull in pulls:
        state = rod.solve_static(rod.loads([pull]), state)
    assert state is not None
    return tension_along(rod, state, 0)


@pytest.mark.parametrize("count", [1, 3, 5, 12])
def test_the_tension_behind_a_hole_is_the_product_of_the_capstans_up_to_it(count: int) -> None:
    """Half of a span's bend is at the base's hole, a span's at each other; between holes the tension is the same."""
    s, tension = along(arc(count), 10.0)
    passed = np.floor(s[1:-1] / (LENGTH / count) + 1e-9)
    angles = BEND / count * (0.5 + passed)
    np.testing.assert_allclose(tension[1:-1], 10.0 * np.exp(-MU * angles), rtol=1e-4)


@pytest.mark.parametrize("count", [3, 12])
def test_let_out_a_tendon_slides_at_the_first_holes_and_sticks_at_the_others(count: int) -> None:
    s, tension = along(arc(count), 10.0, 7.0)
    angles = BEND / count * (0.5 + np.floor(s[1:-1] / (LENGTH / count) + 1e-9))
    expected = np.minimum(7.0 * np.exp(MU * angles), 10.0 * np.exp(-MU * angles))
    np.testing.assert_allclose(tension[1:-1], expected, rtol=1e-4)


def test_many_holes_are_a_sheath_and_few_lack_half_a_span_at_the_end() -> None:
    sheath = float(along(arc(0), 10.0)[1][-1])
    for count in (2, 6, 24):
        last = float(along(arc(count), 10.0)[1][-1])
        assert last / sheath == pytest.approx(math.exp(0.5 * MU * BEND / count), rel=2e-3)


def test_a_rod_that_its_tendon_bends_from_hole_to_hole_is_an_arc_in_each_span() -> None:
    """EI k = r T in a span, and T_i = T_(i-1) exp(-mu (k_(i-1) + k_i) d / 2) at the hole before it."""
    count, pull = 4, 20.0
    span, before, turned, bend = LENGTH / count, pull, 0.0, 0.0
    tip = np.zeros(3)
    for _ in range(count):
        tension = before
        for _ in range(50):
            tension = before * math.exp(-MU * 0.5 * (turned + ARM * tension / STIFFNESS) * span)
        before, turned = tension, ARM * tension / STIFFNESS
        after = bend + turned * span
        tip += np.array((math.cos(bend) - math.cos(after), 0.0, math.sin(after) - math.sin(bend))) / turned
        bend = after
    spans = (Section.round(span, 1e-3, 190e9, 7850.0, bending_modes=2, torsion_modes=0, stretch_modes=0),) * count
    tips = []
    for places in (holes(count), ()):
        rod = StrainRod(Robot(spans, (Tendon(LENGTH, (ARM, 0.0), SPRING, MU, holes=places),)))
        tips.append(rod.tip(rod.solve_static(rod.loads([pull])))[0])
    assert np.linalg.norm(tips[0] - tip) < 2e-4 * LENGTH
    assert np.linalg.norm(tips[1] - tip) > 1e-3 * LENGTH  # a sheath's, of the same angles in all


def test_friction_in_holes_gives_no_energy() -> None:
    tendons = tuple(Tendon(LENGTH, (arm, 0.0), SPRING, MU, holes=holes(5)) for arm in (ARM, -ARM))
    rod = StrainRod(Robot((SECTION,), tendons), 0.005)
    state = rod.solve_static(rod.loads([5.0, 5.0]))
    lost = 0.0
    for k in range(60):
        loads = rod.loads([5.0 + 10.0 * math.sin(0.2 * k) ** 2, 5.0])
        new = rod.step(state, loads)
        assert new.friction_work >= 0.0
        assert balance_of(rod, state, new, loads).lost > -1e-12 or new.steps > 1
        lost += new.friction_work
        state = new
    assert lost > 1e-3


def test_disks_of_the_configuration_are_the_holes_and_must_be_there() -> None:
    section = {"length": LENGTH, "radius": 1e-3, "youngs_modulus": 190e9, "density": 7850.0}
    tendon = {"position": (ARM, 0.0), "friction": MU, "guides": "disks"}
    with_disks = RodSection.model_validate(
        {"section": [{**section, "disk_number": 5, "disk_mass": 1e-3}], "tendon": [tendon]}
    )
    assert robot_from_section(with_disks).tendons[0].holes == pytest.approx(holes(5))
    with pytest.raises(ParameterError, match=r"rod\.tendon\[0\]\.guides = 'disks': no section has disks"):
        robot_from_section(RodSection.model_validate({"section": [section], "tendon": [tendon]}))
    with pytest.raises(ParameterError, match="holes must ascend"):
        Robot((SECTION,), (Tendon(LENGTH, (ARM, 0.0), holes=(0.3, 0.2)),))
