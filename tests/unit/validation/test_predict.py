"""What a rod predicts along a sequence: arcs where theory says so, and memory where there is play or dry friction."""

import numpy as np
import pytest

from tendond.offline.validation.baselines.constant_curvature import bends, predict_arcs
from tendond.offline.validation.rods.build import build
from tendond.offline.validation.rods.predict import predict
from tests.unit.validation.robots import DESIGN, TRUE, sweeps, values_of


def test_without_weight_a_rod_of_parallel_tendons_is_an_arc() -> None:
    """R. J. Webster, B. A. Jones, IJRR 29 (2010): parallel tendons bend a uniform rod with constant curvature."""
    values = values_of(**TRUE, axial_stiffness=1e5)
    command = sweeps(1)
    tips = predict(build(DESIGN, values), command).tip
    assert np.max(np.linalg.norm(tips - predict_arcs(DESIGN, values, command), axis=1)) < 2e-4 * DESIGN.length


def test_a_stiff_tendon_bends_its_arc_by_displacement_over_radius() -> None:
    values = values_of(tendon_stiffness=1e7)
    bend = bends(DESIGN, values, np.array([[4e-3, -1e-2, -1e-2]]))[0, 0]
    assert bend == pytest.approx((4e-3 / DESIGN.radius, 0.0), rel=1e-5, abs=1e-9)


def test_a_rod_without_friction_forgets_how_it_came() -> None:
    command = sweeps(1)
    tips = predict(build(DESIGN, values_of()), command).tip
    np.testing.assert_allclose(tips[2], tips[7], atol=1e-7)  # the same command, pulled and released


def test_backlash_shifts_a_release_by_twice_its_half_width() -> None:
    play = 4e-4
    command = sweeps(1, points=13)  # in steps of 0.5 mm
    behind = predict(build(DESIGN, values_of(backlash=play)), command)
    np.testing.assert_allclose(behind.drawn[6, 0], command[6, 0] - play)
    np.testing.assert_allclose(behind.drawn[19, 0], command[19, 0] + play)


def test_friction_holds_a_released_tendon_where_its_tension_was_higher() -> None:
    command = sweeps(1, points=13)
    sticky = predict(build(DESIGN, values_of(friction=0.5)), command)
    free = predict(build(DESIGN, values_of()), command)
    pulled, released = 6, 19
    np.testing.assert_array_equal(command[pulled], command[released])
    assert sticky.tension[pulled, 0] < free.tension[pulled, 0] < sticky.tension[released, 0]


def test_a_backbone_that_yields_stays_bent_by_the_yielding_share() -> None:
    """Iwan's element: without moment, EI (u - c p) = 0 with |u - p| at the yield curvature, so u = c y / (1 - c)."""
    share, limit = 0.25, 0.5
    command = np.array([[-0.01, 0.0, -0.01], [-0.01, 3e-3, -0.01], [-0.01, -0.01, -0.01]])
    values = values_of(yielding=share / (1.0 - share), yield_curvature=limit)
    measured = build(DESIGN, values)
    tips = predict(measured, command).tip
    remaining = share * limit / (1.0 - share)
    across, turn = (1.0 - np.cos(remaining * 0.2)) / remaining, np.radians(120.0)  # where the second tendon is
    arc = np.array([across * np.cos(turn), across * np.sin(turn), np.sin(remaining * 0.2) / remaining])
    np.testing.assert_allclose(tips[2], arc, atol=0.02 * across)  # what a pose leaves of the yielding
    np.testing.assert_allclose(tips[0], (0.0, 0.0, 0.2), atol=1e-9)


def test_prediction_of_a_rod_leaves_no_trace_in_the_next() -> None:
    values = values_of(yielding=0.5, yield_curvature=0.3)
    first, again = (predict(build(DESIGN, values), sweeps(1)).tip for _ in range(2))
    np.testing.assert_array_equal(first, again)
