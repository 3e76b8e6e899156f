"""Many rods at once: the same numbers as one by one, for whatever parameters, loads and threads."""

import copy
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.strain import Body, Robot, Section, StrainRod, StrainState, Tendon
from tendond.model.strain.batch import RodBatch
from tests.unit.strain.robots import paper

ROBOTS = [paper(damping=damping, drag=drag) for damping, drag in ((8e-3, 0.1), (1e-3, 0.0), (0.0, 50.0))]


def test_rods_of_different_parameters_and_loads_step_as_they_do_alone_to_the_last_bit() -> None:
    robots = [ROBOTS[k % 3] for k in range(7)]
    rng = np.random.default_rng(5)
    tensions, forces = rng.uniform(0.0, 20.0, (6, 7, 4)), rng.normal(size=(6, 7, 3))
    together, threaded = RodBatch(robots), RodBatch(robots, workers=3)
    together.step(tensions, tip_force=forces, steps=6)
    with ThreadPoolExecutor(2) as pool:
        threaded.step(tensions, tip_force=forces, steps=6, run=pool.map)
    for index, robot in enumerate(robots):
        rod = StrainRod(robot)
        state = rod.rest()
        for given, force in zip(tensions[:, index], forces[:, index], strict=True):
            state = rod.step(state, rod.loads(given, tip_force=force))
        for batch in (together, threaded):
            assert np.array_equal(batch.strain[index], state.strain)
            assert np.array_equal(batch.state(index).rate, state.rate)
    assert np.all(together.counts[:, 1] >= 6)
    assert len(together) == 7


def test_rods_of_different_shape_and_routes_step_as_they_do_alone_to_the_last_bit() -> None:
    """Kernels keep modes and routes at their points beside the other working arrays, which a batch's rods share."""
    robots = []
    for radius, at, length in ((0.02, 0.21, 0.5), (0.03, 0.22, 0.5), (0.02, 0.252, 0.6), (0.02, 0.21, 0.5)):
        section = Section.round(length, 1e-3, 190e9, 17189.0, bending_damping=(1e-3,) * 3)
        tendons = (Tendon(length, (radius, 0.0)), Tendon.helical(length, radius, turns=0.3))
        robots.append(Robot((section,), tendons, (Body(at, 0.01),), (-9.81, 0.0, 0.0)))
    batch = RodBatch(robots)
    batch.step([4.0, 2.0], steps=5)
    for index, robot in enumerate(robots):
        rod = StrainRod(robot)
        state = rod.rest()
        for _ in range(5):
            state = rod.step(state, rod.loads([4.0, 2.0]))
        assert np.array_equal(batch.strain[index], state.strain)


def test_tips_and_displacements_that_are_followed_are_those_after_each_step() -> None:
    rng = np.random.default_rng(6)
    tensions = rng.uniform(0.0, 20.0, (5, 3, 4))
    batch = RodBatch(ROBOTS)
    track = batch.follow(tensions, steps=5)
    for index, robot in enumerate(ROBOTS):
        rod = StrainRod(robot)
        state = rod.rest()
        for k in range(5):
            state = rod.step(state, rod.loads(tensions[k, index]))
            assert np.allclose(track.tip[k, index], rod.tip(state)[0], rtol=0.0, atol=1e-14)
            assert np.allclose(track.displacement[k, index], rod.displacements(state), rtol=0.0, atol=1e-14)


def test_states_that_are_written_are_copied_in() -> None:
    batch, rod = RodBatch(ROBOTS[:2]), StrainRod(ROBOTS[1])
    bent = rod.solve_static(rod.loads([5.0, 0.0, 0.0, 0.0])).strain
    batch.strain = np.tile(bent, (2, 1)).T.copy().T  # not contiguous
    batch.step([0.0] * 4)
    assert np.array_equal(batch.strain[1], rod.step(StrainState(bent, np.zeros(rod.modes)), rod.loads()).strain)


def test_a_batch_cannot_be_copied() -> None:
    with pytest.raises(TypeError, match="cannot be copied"):
        copy.deepcopy(RodBatch(ROBOTS[:1]))


def test_displacement_commands_drive_a_batch_as_they_drive_one_rod() -> None:
    batch, rod = RodBatch(ROBOTS[:2]), StrainRod(ROBOTS[1])
    command = [5e-3, 0.0, -4e-3, 0.0]
    batch.step(displacement=command, steps=3)
    state = rod.rest()
    for _ in range(3):
        state = rod.step(state, rod.loads(displacement=command))
    assert np.array_equal(batch.strain[1], state.strain)


def test_what_a_batch_cannot_take_is_refused() -> None:
    with pytest.raises(ParameterError, match="robot 1 has not the structure"):
        RodBatch([ROBOTS[0], paper(torsion_modes=2)])
    with pytest.raises(ParameterError, match="robots is empty"):
        RodBatch([])
    batch = RodBatch(ROBOTS[:2])
    changes: tuple[tuple[dict[str, list[float]], str], ...] = (
        ({}, "one of them"),
        ({"tension": [1.0] * 3}, r"one of \(4,\), \(2, 4\), \(1, 2, 4\)"),
        ({"tension": [-1.0] * 4}, "cannot push"),
        ({"tension": [np.nan] * 4}, "not finite"),
    )
    for change, said in changes:
        with pytest.raises(ParameterError, match=said):
            batch.step(change.get("tension"))
    plain = replace(ROBOTS[0], tendons=tuple(replace(one, stiffness=None) for one in ROBOTS[0].tendons))
    with pytest.raises(ParameterError, match="only be driven by tension"):
        RodBatch([Robot(plain.sections, plain.tendons)]).step(displacement=[0.0] * 4)


def test_a_state_that_is_not_finite_is_reported() -> None:
    batch = RodBatch(ROBOTS[:1])
    batch.rate[0, 0] = np.nan
    with pytest.raises(ConvergenceError, match="not finite"):
        batch.step([0.0] * 4)
