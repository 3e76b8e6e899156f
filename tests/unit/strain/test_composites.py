"""Sums section by section from the tip beside the plain sums over all mass points and nodes that they stand for."""

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.strain import Body, Robot, Section, StrainRod
from tendond.model.strain.kinematics import Shape, find_shape
from tendond.model.strain.stepping.balance import begin_step, find_residual
from tendond.model.strain.stepping.mass import mass_matrix
from tendond.model.strain.stepping.own_turns import add_spins
from tendond.model.strain.stepping.tangent import find_matrix

Array = NDArray[np.float64]


def uneven() -> StrainRod:
    """Three sections of 12, 10 and 7 modes, whose blocks of eight begin in the middle of a section, with drag."""
    modes = ((4, 3, 1), (3, 3, 1), (3, 1, 0))
    sections = tuple(
        Section.round(
            0.1,
            8e-4,
            60e9,
            6450.0,
            bending_modes=bend,
            torsion_modes=twist,
            stretch_modes=stretch,
            drag=(0.3, 0.2, 0.1),
        )
        for bend, twist, stretch in modes
    )
    bodies = (Body(0.2, 0.01), Body(0.3, 0.02, (1e-6, 2e-6, 2.5e-6), (0.004, 0.0, 0.01)))
    return StrainRod(Robot(sections, (), bodies, (1.0, -9.0, 2.0)))


def taken(rod: StrainRod) -> None:
    """Put a step between two strains that are far from a balance into the rod's arrays."""
    rng, work = np.random.default_rng(4), rod._work
    turns = rod.layout.component < 3
    size = np.where(turns, 5.0, 1e-3)
    q0, w0 = rng.normal(size=(2, rod.modes)) * size
    work.q1[:] = q0 + 0.1 * rng.normal(size=rod.modes) * size
    work.q0[:] = q0
    find_shape(rod.layout, q0, work.before)
    begin_step(rod.layout, q0, w0, rod.time_step, work)
    find_residual(rod.layout, rod.loads(tip_force=(0.1, 0.2, -0.1)), q0, work.q1, rod.time_step, work)


def jacobian(rod: StrainRod, shape: Shape) -> Array:
    return np.asarray(shape.jacobian[:, :, : rod.modes])


def test_the_mass_matrix_is_the_sum_over_all_points_and_nodes() -> None:
    rod = uneven()
    taken(rod)
    shape, layout = rod._work.after, rod.layout
    moved, spin = jacobian(rod, shape), shape.spin[:, : rod.modes]
    plain = np.einsum("pia,p,pib->ab", moved, layout.mass, moved) + np.einsum("ka,k,kb->ab", spin, layout.polar, spin)
    assert mass_matrix(layout, shape, rod._work) == pytest.approx(plain, rel=1e-11, abs=1e-12 * np.abs(plain).max())


def test_own_turns_are_the_sum_over_all_nodes() -> None:
    rod = uneven()
    taken(rod)
    work, h = rod._work, rod.time_step
    add_spins(rod.layout, h, work)
    both = (work.before.spin + work.after.spin)[:, : rod.modes]
    plain = np.einsum("ka,k,kb->ab", both, 0.5 * rod.layout.polar / h**2, both)
    width = int(len(work.spun) ** 0.5)
    found = work.spun.reshape(width, width)[: rod.modes, : rod.modes]
    assert found == pytest.approx(plain, rel=1e-11, abs=1e-12 * np.abs(plain).max())


def test_inertia_and_drag_of_a_step_are_the_sum_over_all_points() -> None:
    rod = uneven()
    taken(rod)
    work, layout, h = rod._work, rod.layout, rod.time_step
    find_matrix(layout, h, work)
    j0, j1 = jacobian(rod, work.before), jacobian(rod, work.after)
    moved = work.after.point - work.before.point
    axes = 0.5 * (work.before.rotation + work.after.rotation).reshape(-1, 3, 3)[layout.place]
    inertia = 2.0 * layout.mass[:, None, None] / h**2 * np.eye(3)
    slopes = 2.0 * layout.drag * np.abs(np.einsum("pic,pi->pc", axes, moved)) / h**2
    inertia = inertia + np.einsum("pc,pic,pjc->pij", slopes, axes, axes)
    plain = np.einsum("pia,pij,pjb->ab", 0.5 * (j0 + j1), inertia, j1)
    width = int(len(work.total) ** 0.5)
    found = work.total.reshape(width, width)[: rod.modes, : rod.modes]
    assert found == pytest.approx(plain, rel=1e-10, abs=1e-11 * np.abs(plain).max())
