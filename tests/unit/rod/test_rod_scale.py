"""The solver has no unit: a small or soft rod is solved as exactly as the paper's robot, and in as many steps."""

from dataclasses import replace

import numpy as np
import pytest

from tendond.model import Rod, RodParameters
from tendond.model.rod.parameters import Triple
from tests.unit.rod.rods import PAPER, Array, one_tendon

each_drive = pytest.mark.parametrize("displacement_driven", [False, True])


def times(factor: float, a: Triple) -> Triple:
    return factor * a[0], factor * a[1], factor * a[2]


def scaled(force: float, length: float) -> RodParameters:
    """Make the paper's robot in other units of force and length, and the same of time."""
    area = length**2
    return replace(
        PAPER,
        length=length * PAPER.length,
        radius=length * PAPER.radius,
        youngs_modulus=force / area * PAPER.youngs_modulus,
        density=force / area**2 * PAPER.density,
        bending_damping=times(force * area, PAPER.bending_damping),
        drag=times(force / length**3, PAPER.drag),
        gravity=times(length, PAPER.gravity),
        tendon_positions=tuple((length * x, length * y) for x, y in PAPER.tendon_positions),
        tendon_stiffness=force / length * PAPER.tendon_stiffness,
    )


def tips(parameters: RodParameters, force: float, length: float, displacement_driven: bool) -> tuple[Array, list[int]]:
    """Tips of a pull, a push and the motion after it [unit of length], and the marches of each step."""
    rod = Rod(parameters)
    pull, push = one_tendon(8.0) * force, (0.0, 0.3 * force, -0.1 * force)
    state = rod.solve_static(displacements=one_tendon(0.01) * length) if displacement_driven else rod.solve_static(pull)
    found, marches = [rod.tip(state).position], [state.marches]
    for k in range(30):
        load = push if k < 5 else (0.0, 0.0, 0.0)
        if displacement_driven:
            state = rod.step(state, displacements=one_tendon(0.01 + 0.002 * (k > 10)) * length, tip_force=load)
        else:
            state = rod.step(state, one_tendon(8.0 + 6.0 * (k > 10)) * force, tip_force=load)
        found.append(rod.tip(state).position)
        marches.append(state.marches)
    return np.array(found) / length, marches


@each_drive
@pytest.mark.parametrize("force", [2.0**-14, 2.0**10])
def test_a_rod_in_another_unit_of_force_moves_the_same_to_the_last_bit(force: float, displacement_driven: bool) -> None:
    """Powers of two, with which a float is multiplied without rounding."""
    expected, marches = tips(PAPER, 1.0, 1.0, displacement_driven)
    found, spent = tips(scaled(force, 1.0), force, 1.0, displacement_driven)
    assert spent == marches
    assert np.array_equal(found, expected)


@each_drive
@pytest.mark.parametrize(("force", "length"), [(1.0, 2.0**-5), (2.0**-6, 2.0**3)])
def test_a_rod_of_another_size_moves_likewise(force: float, length: float, displacement_driven: bool) -> None:
    """Agreement, but not to the last bit: elimination takes the largest pivot, of forces and moments together."""
    expected, _ = tips(PAPER, 1.0, 1.0, displacement_driven)
    found, _ = tips(scaled(force, length), force, length, displacement_driven)
    assert found == pytest.approx(expected, abs=1e-7 * PAPER.length)


@pytest.mark.parametrize("radius", [0.25e-3, 0.1e-3, 0.05e-3])
def test_statics_of_a_thin_nitinol_wire_are_as_exact_as_those_of_the_papers_robot(radius: float) -> None:
    """A tip force of 1e-6 N moves the tip of the thinnest wire, 0.3 m long, by a tenth of its length."""
    wire = RodParameters(
        length=0.3, radius=radius, youngs_modulus=60e9, density=6450.0,
        tendon_positions=((0.002, 0.0), (0.0, 0.002), (-0.002, 0.0), (0.0, -0.002)),
    )  # fmt: skip
    EI, L = wire.bending_stiffness, wire.length
    usual, exact = Rod(wire), Rod(wire, tolerance=1e-10 * EI / L**2)
    rng = np.random.default_rng(1)
    for _ in range(20):
        tensions, force = rng.uniform(0.0, np.pi / 2.0 * EI / L / 0.002, 4), rng.normal(size=3) * EI / L**2
        ends = [rod.tip(rod.solve_static(tensions, tip_force=force)).position for rod in (usual, exact)]
        assert np.linalg.norm(ends[0] - ends[1]) < 1e-5 * L
