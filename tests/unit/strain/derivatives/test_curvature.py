"""Second derivatives of a shape against central differences of its Jacobians, for drawn strains, rates and loads."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.numerics.parked import park
from tendond.model.strain import Body, Robot, Section, StrainRod, Tendon
from tendond.model.strain.composites import curvature_of_points
from tendond.model.strain.derivatives.rates import empty_rates, find_rates
from tendond.model.strain.kinematics import empty_shape, find_shape
from tendond.model.strain.second_derivatives.bends import bends_of
from tendond.model.strain.second_derivatives.curvature import add_curvature
from tendond.model.strain.stepping.scratch import Scratch

Array = NDArray[np.float64]
Values = Callable[[Array], tuple[Array, ...]]


def differences(values: Values, q: Array, step: Array) -> list[Array]:
    """Derivatives of several arrays by q, fourth order, the last axis that of q."""
    columns = []
    for b, unit in enumerate(np.eye(len(q))):
        near, far = ([values(q + side * part * step[b] * unit) for side in (1, -1)] for part in (1.0, 2.0))
        columns.append(
            [
                (8.0 * (up - down) - (higher - lower)) / (12.0 * step[b])
                for up, down, higher, lower in zip(*near, *far, strict=True)
            ]
        )
    return [np.stack(parts, axis=-1) for parts in zip(*columns, strict=True)]


@pytest.mark.parametrize("bend", [0.0, 6.0, 60.0])
def test_second_derivatives_of_the_shape_are_exact_however_far_it_is_bent(bend: float) -> None:
    half = Section.round(
        0.2, 1e-3, 190e9, 8000.0, torsion_modes=2, bending_modes=3, curvature=(1.0, -3.0, 4.0)
    )  # fmt: skip
    rod = StrainRod(
        Robot((half, half), (), (Body(0.4, 0.05, (1e-5, 2e-5, 1.5e-5), (0.01, 0.0, 0.02)), Body(0.2, 0.01)))
    )
    layout, rng = rod.layout, np.random.default_rng(1)
    turns = layout.component < 3
    q = rng.normal(size=rod.modes) * np.where(turns, bend, 0.01)
    w = rng.normal(size=rod.modes) * np.where(turns, 6.0, 0.1)
    shape, other, rates = empty_shape(layout), empty_shape(layout), empty_rates(layout)
    bends = bends_of(layout)
    find_shape(layout, q, shape)
    force, moment = rng.normal(size=shape.point.shape), rng.normal(size=(len(layout.polar), 3))
    spin = rng.normal(size=len(layout.polar))
    curvature = np.zeros((rod.modes, rod.modes))
    add_curvature(layout, shape, force, moment, spin, bends, curvature)
    find_rates(layout, w, shape, bends, rates)

    def along(q: Array) -> tuple[Array, ...]:
        """Forces by modes, velocities of points, rotation rates, from the Jacobians of the march."""
        find_shape(layout, q, other)
        columns = []
        for unit in np.eye(rod.modes):
            find_rates(layout, unit, other, bends, empty)
            columns.append(empty.node[:, :3].copy())
        turn = np.array(columns)
        moved = np.array([other.jacobian[:, :, d] for d in range(rod.modes)])
        own = other.spin[:, : rod.modes]
        pulled = np.einsum("npi,pi->n", moved, force) + np.einsum("nki,ki->n", turn, moment) + own.T @ spin
        return pulled, np.einsum("npi,n->pi", moved, w), own @ w

    empty = empty_rates(layout)
    step = np.where(turns, 1e-5 * max(1.0, bend), 1e-7 * max(1.0, bend))
    expected = differences(along, q, step)
    for found, truth in zip(
        (curvature, rates.point[:, :, : rod.modes], rates.spin[:, : rod.modes]), expected, strict=True
    ):
        assert np.abs(found - truth).max() < 1e-6 * np.abs(truth).max()


def test_the_motion_of_a_shape_is_its_jacobian_times_the_rates() -> None:
    rod = StrainRod(Robot((Section.round(0.3, 1e-3, 190e9, 8000.0, torsion_modes=2),)))
    layout, rng = rod.layout, np.random.default_rng(2)
    q, w = rng.normal(size=(2, rod.modes))
    shape, rates = empty_shape(layout), empty_rates(layout)
    bends = bends_of(layout)
    find_shape(layout, q, shape)
    find_rates(layout, w, shape, bends, rates)
    velocity = np.cross(rates.node[layout.place][:, :3], shape.point) + rates.node[layout.place][:, 3:]
    moved = np.array([shape.jacobian[:, :, d] for d in range(rod.modes)])
    assert velocity == pytest.approx(np.einsum("npi,n->pi", moved, w), abs=1e-12)


def with_knots(knots: int, tendons: int) -> StrainRod:
    """A rod whose precurvature is a table, with an interval between each of its rows."""
    rows = [(s, 0.1 * math.sin(9.0 * s), 0.0, 0.0) for s in np.linspace(0.0, 0.5, knots + 2)]
    plain = Section.round(0.5, 1e-3, 190e9, 7850.0, tables={"curvature": rows})
    return StrainRod(Robot((plain,), tuple(Tendon(0.5, (0.02, 0.001 * k)) for k in range(tendons))))


@pytest.mark.parametrize(("knots", "tendons"), [(6, 0), (8, 0), (8, 4), (20, 1)])
def test_there_is_a_row_for_each_interval_of_a_table(knots: int, tendons: int) -> None:
    rod = with_knots(knots, tendons)
    width = math.isqrt(len(rod._work.total))
    assert len(rod._work.left) >= 3 * len(rod.layout.step) * width
    state = rod.step(rod.rest(), rod.loads([1.0] * tendons, tip_force=(0.0, 0.1, 0.0)))
    assert np.all(np.isfinite(state.strain))


def test_sums_for_sections_of_few_modes_stay_within_their_arrays() -> None:
    """Three sections of five modes: the last block of rows begins at 10 and not at a multiple of four."""
    section = Section.round(0.1, 5e-4, 60e9, 6450.0, bending_modes=2, torsion_modes=1, stretch_modes=0)
    rod = StrainRod(Robot((section,) * 3))
    n = rod.modes
    assert n == 15
    shape, work = empty_shape(rod.layout), rod._work
    find_shape(rod.layout, np.linspace(-3.0, 3.0, n), shape)
    force, values = np.ones((len(rod.layout.mass), 3)), {name: getattr(work, name) for name in Scratch._fields}
    found, other = np.zeros((n, n)), np.zeros((n, n))
    for guard, out in ((np.nan, found), (1.0, other)):
        guarded = np.full(16**2 + 4 * 16, guard)  # the rows after the last one
        room = park(Scratch(**{**values, "total": guarded[: 16**2]}))
        curvature_of_points(rod.layout, shape, force, room, out)
        assert np.array_equal(guarded[16**2 :], np.full(64, guard), equal_nan=True)
    assert np.all(np.isfinite(found))
    assert np.array_equal(found, other)
