"""Sections whose properties change along them, precurvature, shear and routes by points, against closed forms."""

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import fresnel

from tendond.model.errors import ParameterError
from tendond.model.strain import Robot, Section, StrainRod, Tendon
from tests.reference.routing import Piece, solve_routing

MODULUS, DENSITY, LENGTH = 70e9, 2700.0, 0.4


def cone(first: float, last: float, **more: Any) -> Section:
    """A section whose radius changes linearly."""
    return Section.tapered(LENGTH, [[0.0, first], [LENGTH, last]], MODULUS, DENSITY, **more)


def test_a_conical_cantilever_bends_as_its_closed_form_says() -> None:
    """Tip load P: P L^3 / (3 E I_base) times d_base / d_tip (integral of P x^2 / E I(x))."""
    rod = StrainRod(Robot((cone(2e-3, 1e-3, bending_modes=8),)))
    base = MODULUS * math.pi / 4.0 * 2e-3**4
    load = 1e-3
    tip, _ = rod.tip(rod.solve_static(rod.loads(tip_force=(load, 0.0, 0.0))))
    assert tip[0] == pytest.approx(load * LENGTH**3 / (3.0 * base) * 2.0, rel=2e-4)


def test_the_moment_of_a_cone_s_mass_about_its_base_is_exact() -> None:
    rod = StrainRod(Robot((cone(2e-3, 1e-3),)))
    along = rod.backbone(rod.rest())[rod.layout.place, 2]
    moment = DENSITY * math.pi * LENGTH**2 * (4e-6 / 12.0 + 2e-6 / 6.0 + 1e-6 / 4.0)
    assert rod.layout.mass @ along == pytest.approx(moment, rel=1e-12)


def test_a_table_that_does_not_change_is_a_constant() -> None:
    plain = StrainRod(Robot((Section.round(LENGTH, 1e-3, MODULUS, DENSITY, drag=(0.1, 0.1, 0.1)),))).layout
    rows = [[0.0, 1e-3], [0.13, 1e-3], [LENGTH, 1e-3]]
    drag = {"drag": [[0.0, 0.1, 0.1, 0.1], [0.2, 0.1, 0.1, 0.1]]}
    table = StrainRod(Robot((Section.tapered(LENGTH, rows, MODULUS, DENSITY, tables=drag),))).layout
    for name in plain._fields:
        scale = np.max(np.abs(getattr(plain, name)), initial=0.0)
        assert getattr(table, name) == pytest.approx(getattr(plain, name), rel=1e-12, abs=1e-12 * scale), name


def test_a_tapered_rod_with_a_tendon_bends_as_the_balance_of_a_cut_says() -> None:
    count = 48
    tendon = Tendon.converging(LENGTH, (0.01, 0.0), (0.005, 0.0))
    rod = StrainRod(Robot((cone(1.5e-3, 1e-3, bending_modes=8, torsion_modes=2, stretch_modes=3),), (tendon,)))
    state = rod.solve_static(rod.loads([20.0]))
    pieces = []
    for middle in (np.arange(count) + 0.5) / count:
        radius = 1.5e-3 - 0.5e-3 * middle
        second, area = math.pi * radius**4 / 4.0, math.pi * radius**2
        EI = MODULUS * second
        pieces.append(Piece(LENGTH / count, (EI, EI, EI / 1.3), MODULUS * area))
    expected, _ = solve_routing(pieces, [(20.0, LENGTH, tendon.at)])
    assert expected[0] > 0.07
    assert np.linalg.norm(rod.tip(state)[0] - expected) < 1e-4 * LENGTH


def test_constant_curvature_and_twist_make_a_helix() -> None:
    curvature, twist = 12.0, 5.0
    rod = StrainRod(Robot((Section.round(LENGTH, 1e-3, MODULUS, DENSITY, curvature=(curvature, 0.0, twist)),)))
    total = math.hypot(curvature, twist)
    angle, axis = total * LENGTH, np.array([curvature, 0.0, twist]) / total
    along = np.array([0.0, 0.0, 1.0])
    expected = (
        along * math.sin(angle) + np.cross(axis, along) * (1.0 - math.cos(angle))
        + axis * (axis @ along) * (angle - math.sin(angle))
    ) / total  # fmt: skip
    assert rod.tip(rod.rest())[0] == pytest.approx(expected, abs=1e-12)


def test_a_table_of_precurvature_that_grows_evenly_is_a_clothoid() -> None:
    rate = 20.0  # of curvature [1/m^2]
    tables = {"curvature": [[0.0, 0.0, 0.0, 0.0], [LENGTH, 0.0, rate * LENGTH, 0.0]]}
    rod = StrainRod(Robot((Section.round(LENGTH, 1e-3, MODULUS, DENSITY, tables=tables, bending_modes=8),)))
    unit = math.sqrt(math.pi / rate)
    across, along = fresnel(LENGTH / unit)
    assert rod.tip(rod.rest())[0] == pytest.approx((unit * across, 0.0, unit * along), abs=1e-6)


def test_a_thick_beam_shears_as_timoshenko_says() -> None:
    GA = 2e3
    section = Section.round(0.1, 5e-3, 1e6, 1000.0, shear_stiffness=GA, shear_modes=2)
    rod = StrainRod(Robot((section,)))
    load = 1e-4
    tip, _ = rod.tip(rod.solve_static(rod.loads(tip_force=(load, 0.0, 0.0))))
    EI = section.bending_stiffness[0]
    assert tip[0] == pytest.approx(load * 0.1**3 / (3.0 * EI) + load * 0.1 / GA, rel=1e-6)


def test_a_route_by_two_points_is_a_converging_tendon() -> None:
    section = Section.round(LENGTH, 1e-3, MODULUS, DENSITY)
    rows = [[0.0, 0.01, 0.0], [LENGTH, 0.004, 0.002]]
    tips = []
    for tendon in (Tendon.tabulated(LENGTH, rows), Tendon.converging(LENGTH, (0.01, 0.0), (0.004, 0.002))):
        rod = StrainRod(Robot((section,), (tendon,)))
        tips.append(rod.tip(rod.solve_static(rod.loads([2.0])))[0])
    assert tips[0] == pytest.approx(tips[1], abs=1e-9)


def test_a_base_elsewhere_moves_the_robot_and_nothing_else() -> None:
    section = Section.round(LENGTH, 1e-3, MODULUS, DENSITY)
    there = (1.0, -2.0, 0.5)
    rods = [StrainRod(Robot((section,), gravity=(-9.81, 0.0, 0.0), origin=origin)) for origin in ((0.0,) * 3, there)]
    states = [rod.step(rod.solve_static(rod.loads(tip_force=(0.1, 0.0, 0.0))), rod.loads()) for rod in rods]
    assert rods[1].tip(states[1])[0] - there == pytest.approx(rods[0].tip(states[0])[0], abs=1e-9)
    assert states[1].rate == pytest.approx(states[0].rate, rel=1e-5, abs=1e-6)


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"length": [[0.0, 1.0], [1.0, 1.0]]}, "length cannot be a table"),
        ({"curvature": [[0.0, 1.0], [1.0, 1.0]]}, "two or more rows"),
        ({"drag": [[0.2, 1.0, 1.0, 1.0], [0.1, 1.0, 1.0, 1.0]]}, "must ascend"),
        ({"mass_per_length": [[0.0, 1.0], [0.2, -1.0]]}, "above 0"),
        ({"axial_stiffness": [[0.0, 1.0], [0.2, math.nan]]}, "not finite"),
    ],
)
def test_tables_that_cannot_be_are_refused(tables: dict[str, list[list[float]]], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        Section.round(LENGTH, 1e-3, MODULUS, DENSITY, tables=tables)
