"""The kernels agree with the plain reference (tests/reference): other code, other solver, the same discrete equations.

What may differ is rounding and what the solvers leave at the tip, 1e-11 N and N m on either side. That moves the tip by
some 1e-12 m; accelerations are position differences over dt^2 and carry 1e4 times as much, near 1e-10 of themselves.

The reference's solver is slow, so most cases lead the reference along: it sweeps the rod once from the kernel's base
load. Nothing is then missing at its tip, by its own equations, so that the kernel's solution is its solution too.
"""

from typing import TypedDict

import numpy as np
import pytest

from tendond.model import Rod, RodParameters, RodState
from tendond.model.solver.predictor import RING
from tendond.model.solver.schemes import SCHEMES
from tests.reference import (
    Loads,
    ReferenceModel,
    ReferenceRod,
    Solution,
    Tableau,
    solve_static_displacements,
    step_displacements,
)
from tests.reference.schemes import Scheme as ReferenceScheme
from tests.unit.rod.rods import PAPER, Array, External, one_tendon, relative

AGREEMENT = 1e-9
LEFT_AT_THE_TIP = 1e-11
FEW_NODES = {"euler": 24, "rk4": 6, "rk6": 4}


def reference_model(parameters: RodParameters, space: str, nodes: int) -> ReferenceModel:
    """The reference's rod with the same parameters and the same tableau."""
    scheme = SCHEMES[space]
    a, b = scheme.arrays()
    rod = ReferenceRod(
        length=parameters.length,
        radius=parameters.radius,
        youngs_modulus=parameters.youngs_modulus,
        density=parameters.density,
        poisson_ratio=parameters.poisson_ratio,
        shear_damping=np.array(parameters.shear_damping),
        bending_damping=np.array(parameters.bending_damping),
        drag=np.array(parameters.drag),
        tendon_positions=np.array([(x, y, 0.0) for x, y in parameters.tendon_positions]),
        gravity=np.array(parameters.gravity),
        tip_mass=parameters.tip_mass,
        tip_inertia=np.array(parameters.tip_inertia),
        tip_offset=np.array(parameters.tip_offset),
    )
    return ReferenceModel(
        rod,
        ReferenceScheme(Tableau(a, b, a.sum(axis=1)), nodes - 1, scheme.orthonormal, scheme.trapezoidal),
    )


def some_rod(rng: np.random.Generator, tendons: int) -> RodParameters:
    """Every parameter at random round the paper's, tendons irregularly placed, Bse not zero, a body beside the tip."""

    def three(low: float, high: float) -> tuple[float, float, float]:
        x, y, z = rng.uniform(low, high, 3)
        return float(x), float(y), float(z)

    angles = 2.0 * np.pi * np.arange(tendons) / tendons + rng.uniform(-0.2, 0.2, tendons)
    arms = rng.uniform(0.016, 0.024, tendons)
    return RodParameters(
        length=rng.uniform(0.4, 0.6),
        radius=rng.uniform(0.9e-3, 1.2e-3),
        youngs_modulus=rng.uniform(1.5e11, 2.2e11),
        poisson_ratio=rng.uniform(0.2, 0.4),
        density=rng.uniform(7e3, 2e4),
        shear_damping=three(0.5, 3.0),
        bending_damping=three(0.004, 0.01),
        drag=three(0.05, 0.2),
        gravity=three(-9.0, 9.0),
        tendon_positions=tuple(
            (float(arm * np.cos(at)), float(arm * np.sin(at))) for arm, at in zip(arms, angles, strict=True)
        ),
        tendon_stiffness=rng.uniform(1e4, 3e4),
        tip_mass=rng.uniform(0.005, 0.05),
        tip_inertia=three(1e-6, 1e-5),
        tip_offset=three(-0.02, 0.02),
    )


def some_loads(rng: np.random.Generator) -> External:
    """Force and moment on the tip and along the rod, in all directions."""
    return External(
        tip_force=list(rng.normal(0.0, 0.3, 3)),
        tip_moment=list(rng.normal(0.0, 0.02, 3)),
        distributed_force=list(rng.normal(0.0, 0.2, 3)),
        distributed_moment=list(rng.normal(0.0, 0.02, 3)),
    )


class World(TypedDict):
    """The reference's names for the same loads."""

    tip_force_world: Array
    tip_moment_world: Array
    distributed_force_world: Array
    distributed_moment_world: Array


def world(loads: External) -> World:
    """The loads for the reference."""
    return World(
        tip_force_world=np.array(loads["tip_force"]),
        tip_moment_world=np.array(loads["tip_moment"]),
        distributed_force_world=np.array(loads["distributed_force"]),
        distributed_moment_world=np.array(loads["distributed_moment"]),
    )


def assert_agree(rod: Rod, state: RodState, solution: Solution, *, moving: bool) -> None:
    """Every quantity of the rod, at the tip and along it."""
    tip, expected = rod.tip(state), solution.tip
    pairs = {
        "position": (tip.position, expected.position),
        "rotation": (tip.rotation, expected.R),
        "b_c": (tip.input_gain, expected.b_c),
        "tensions": (state.tensions, solution.tensions),
        "tendon displacements": (rod.displacements(state), solution.tendon_displacements),
        "shape": (state.shape, solution.positions),
        "rotations": (state.rotations, solution.rotations),
        "base load": (state.unknowns[state.count % RING, :6], solution.base_load),
    }
    if moving:
        pairs["velocity"] = (tip.velocity, expected.velocity)
        pairs["acceleration"] = (tip.acceleration, expected.acceleration)
        a_c = expected.acceleration - expected.b_c @ solution.tensions
        pairs["a_c"] = (tip.drift, a_c)
    errors = {name: relative(found, wanted) for name, (found, wanted) in pairs.items()}
    assert max(errors.values()) < AGREEMENT, errors


@pytest.mark.parametrize("space", list(SCHEMES))
def test_both_solvers_find_the_same_motion_under_tensions(space: str) -> None:
    rng = np.random.default_rng(4)
    parameters, tensions = some_rod(rng, 4), rng.uniform(0.0, 6.0, 4)
    rod = Rod(parameters, space, nodes=FEW_NODES[space], tolerance=LEFT_AT_THE_TIP)
    model, loads = reference_model(parameters, space, FEW_NODES[space]), some_loads(rng)
    state = rod.solve_static(tensions, **loads)
    solution = model.solve_static(tensions, **world(loads))
    assert_agree(rod, state, solution, moving=False)
    for _ in range(2):
        tensions, loads = tensions + rng.uniform(-1.0, 4.0, 4).clip(-tensions), some_loads(rng)
        state, solution = rod.step(state, tensions, **loads), model.step(solution, tensions, **world(loads))
        assert_agree(rod, state, solution, moving=True)


@pytest.mark.parametrize("space", list(SCHEMES))
def test_both_solvers_find_the_same_motion_under_displacements(space: str) -> None:
    rng = np.random.default_rng(5)
    parameters, commands = some_rod(rng, 4), np.array([3e-3, 1e-3, -1e-3, -3e-3])
    rod = Rod(parameters, space, nodes=FEW_NODES[space], tolerance=LEFT_AT_THE_TIP)
    model, loads = reference_model(parameters, space, FEW_NODES[space]), some_loads(rng)
    stiffnesses = np.full(4, parameters.tendon_stiffness)
    state = rod.solve_static(displacements=commands, **loads)
    solution = solve_static_displacements(model, commands, stiffnesses, **world(loads))
    assert_agree(rod, state, solution, moving=False)
    commands, loads = np.array([2e-3, 2e-3, 0.0, -4e-3]), some_loads(rng)
    state = rod.step(state, displacements=commands, **loads)
    solution = step_displacements(model, solution, commands, stiffnesses, **world(loads))
    assert_agree(rod, state, solution, moving=True)


def followed(model: ReferenceModel, rod: Rod, state: RodState, loads: Loads, previous: Solution | None) -> Solution:
    """The reference's sweep from the kernel's base load; nothing is missing at its tip."""
    base_load = state.unknowns[state.count % RING, :6]
    if previous is None:
        solution = model.static_solution(loads, base_load)
    else:
        solution = model.step_solution(previous, loads, base_load)
    # A body's inertia is second differences of positions over dt^2, and their rounding.
    assert float(np.linalg.norm(solution.residual)) < 50.0 * LEFT_AT_THE_TIP
    assert_agree(rod, state, solution, moving=previous is not None)
    return solution


@pytest.mark.parametrize("space", list(SCHEMES))
@pytest.mark.parametrize("tendons", [3, 4])
def test_a_tension_driven_motion_in_three_dimensions_is_the_references(space: str, tendons: int) -> None:
    rng = np.random.default_rng(tendons)
    parameters, tensions, loads = some_rod(rng, tendons), rng.uniform(0.0, 6.0, tendons), some_loads(rng)
    rod = Rod(parameters, space, nodes=FEW_NODES[space], tolerance=LEFT_AT_THE_TIP)
    model = reference_model(parameters, space, FEW_NODES[space])
    state = rod.solve_static(tensions, **loads)
    solution = followed(model, rod, state, model.loads(tensions, **world(loads)), None)
    for _ in range(10):
        tensions, loads = rng.uniform(0.0, 20.0, tendons), some_loads(rng)
        state = rod.step(state, tensions, **loads)
        solution = followed(model, rod, state, model.loads(tensions, **world(loads)), solution)


@pytest.mark.parametrize("space", list(SCHEMES))
@pytest.mark.parametrize("tendons", [3, 4])
def test_a_displacement_driven_motion_obeys_the_springs_by_the_references_lengths(space: str, tendons: int) -> None:
    rng = np.random.default_rng(10 + tendons)
    parameters, loads, taut = some_rod(rng, tendons), some_loads(rng), []
    rod = Rod(parameters, space, nodes=FEW_NODES[space], tolerance=LEFT_AT_THE_TIP)
    model = reference_model(parameters, space, FEW_NODES[space])
    state: RodState | None = None
    solution: Solution | None = None
    for _ in range(11):
        commands, loads = rng.uniform(-4e-3, 4e-3, tendons), some_loads(rng)
        if state is None:
            state = rod.solve_static(displacements=commands, **loads)
        else:
            state = rod.step(state, displacements=commands, **loads)
        solution = followed(model, rod, state, model.loads(state.tensions, **world(loads)), solution)
        springs = parameters.tendon_stiffness * (commands - solution.tendon_displacements)
        assert relative(state.tensions, np.maximum(0.0, springs)) < AGREEMENT
        taut.append(int(np.sum(state.tensions > 0.0)))
    assert min(taut) < tendons, "no tendon was slack: the case shows less than it says"
    assert max(taut) > tendons // 2, "no antagonists were taut together"


def test_the_papers_robot_in_its_plane_with_200_nodes_is_the_references() -> None:
    rod, model = Rod(PAPER, "euler", tolerance=LEFT_AT_THE_TIP), reference_model(PAPER, "euler", 200)
    state = rod.solve_static(one_tendon(10.0))
    solution = followed(model, rod, state, model.loads(one_tendon(10.0)), None)
    for tension in (43.0, 43.0, 20.0, 0.0, 60.0):
        state = rod.step(state, one_tendon(tension))
        solution = followed(model, rod, state, model.loads(one_tendon(tension)), solution)
