"""Many rods at once: the same numbers as one by one, for whatever parameters, loads and threads."""

import copy
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.strain import Body, Robot, Section, StrainRod, StrainState, Tendon
from tendond.model.strain.batch import RodBatch
from tendond.model.strain.describe.base import Base
from tests.unit.strain.robots import paper, rubbing

Array = NDArray[np.float64]

ROBOTS = [paper(damping=damping, drag=drag) for damping, drag in ((8e-3, 0.1), (1e-3, 0.0), (0.0, 50.0))]


def test_rods_of_different_parameters_and_loads_step_as_they_do_alone_to_the_last_bit() -> None:
    robots = [ROBOTS[k % 3] for k in range(7)]
    rng = np.random.default_rng(5)
    tensions, forces = rng.uniform(0.0, 20.0, (6, 7, 4)), rng.normal(size=(6, 7, 3))
    together, threaded = RodBatch(robots), RodBatch(robots, workers=3)
    together.step(tension=tensions, tip_force=forces, steps=6)
    with ThreadPoolExecutor(2) as pool:
        threaded.step(tension=tensions, tip_force=forces, steps=6, run=pool.map)
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
    batch.step(tension=[4.0, 2.0], steps=5)
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
    track = batch.follow(tension=tensions, steps=5)
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
    batch.step(tension=[0.0] * 4)
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


STILL, LIFT = None, Base(acceleration=np.array([0.0, 0.0, 2.0]))
SPIN = Base(
    Rotation.from_rotvec([0.0, 0.3, 0.1]).as_matrix(), np.array([0.1, 0.0, 0.2]), np.array([0.5, -1.0, 0.2]),
    np.array([0.5, 2.0, -1.0]), np.zeros(3), np.array([4.0, 0.0, 3.0]),
)  # fmt: skip


def unlike() -> list[Robot]:
    """Robots with four tendons: without friction, with it on all or one of them, on helices, which have more points."""
    plain = ROBOTS[0]
    one = replace(plain, tendons=(replace(plain.tendons[0], friction=0.3), *plain.tendons[1:]))
    quarters = [math.pi / 2 * k for k in range(4)]
    helices = tuple(Tendon.helical(0.5, 0.02, 0.5, start, 2e4, 0.1) for start in quarters)
    return [plain, rubbing(plain, 0.05), rubbing(ROBOTS[1], 0.4), one, replace(plain, tendons=helices), ROBOTS[2]]


def to_and_fro(lanes: int, steps: int) -> Array:
    """Tensions that rise in steps, and fall: slowly enough for the tendons to stick, and fast [N], shape (k, N, 4)."""
    rng = np.random.default_rng(7)
    slow, fast = rng.uniform(2.0, 6.0, (1, lanes, 4)), rng.uniform(0.0, 10.0, (steps, lanes, 4))
    return np.where(np.arange(steps)[:, None, None] % 3 == 2, fast, slow + 0.01 * np.arange(steps)[:, None, None])


@pytest.mark.parametrize("driven", [False, True])
def test_lanes_with_and_without_friction_and_moving_base_step_as_they_do_alone_to_the_last_bit(driven: bool) -> None:
    robots, steps = unlike(), 12
    robots = [*robots, *robots, *robots[::-1]]
    bases: list[Base | None] = [(STILL, LIFT, SPIN)[k // 6] for k in range(len(robots))]
    given = to_and_fro(len(robots), steps)
    given = 1e-3 * (given - 2.0) if driven else given
    name = "displacement" if driven else "tension"
    together, threaded = RodBatch(robots), RodBatch(robots, workers=3)
    acting: Any = {name: given, "base": bases}
    together.step(steps=steps, **acting)
    with ThreadPoolExecutor(2) as pool:
        threaded.step(steps=steps, run=pool.map, **acting)
    slid: set[int] = set()
    for index, robot in enumerate(robots):
        rod, base = StrainRod(robot), bases[index]
        state = rod.rest()
        for k in range(steps):
            loads = rod.loads(**{name: given[k, index]})
            state = rod.step(state, loads, None if base is None else base.after(0.01 * k))
            slid |= set(rod._work.grip.slid.reshape(-1).tolist())
        for batch in (together, threaded):
            assert equal(batch.state(index), state), index
    assert slid == {-1, 0, 1}  # let out, stuck, pulled


def equal(one: StrainState, other: StrainState) -> bool:
    """Whether a rod goes on alike from two states."""
    pairs = [
        (one.strain, other.strain),
        (one.rate, other.rate),
        *zip(one.earlier or (), other.earlier or (), strict=True),
    ]
    if one.pulls is not None and other.pulls is not None:
        pairs.append((one.pulls, other.pulls))
    if one.base is not None and other.base is not None:
        pairs.append((one.base.row(), other.base.row()))
    same = (one.pulls is None, one.base is None) == (other.pulls is None, other.base is None)
    return same and one.friction_work == other.friction_work and all(np.array_equal(a, b) for a, b in pairs)


def test_a_batch_goes_on_from_states_of_rods_and_rods_go_on_from_its() -> None:
    robots = unlike()
    batch, rods = RodBatch(robots), [StrainRod(robot) for robot in robots]
    tension = [8.0, 1.0, 2.0, 1.0]
    states = [rod.solve_static(rod.loads([12.0, 0.0, 1.0, 0.0])) for rod in rods]
    states = [rod.step(state, rod.loads(tension), LIFT) for rod, state in zip(rods, states, strict=True)]
    for index, state in enumerate(states):
        batch.set_state(index, state)
    batch.step(tension=tension, steps=3)  # the bases rest where they were
    for index, rod in enumerate(rods):
        state = states[index]
        for _ in range(3):
            state = rod.step(state, rod.loads(tension))
        assert equal(batch.state(index), state)
        states[index] = rod.step(batch.state(index), rod.loads([1.0] * 4))
    batch.step(tension=[1.0] * 4)
    assert all(equal(batch.state(index), state) for index, state in enumerate(states))
    with pytest.raises(ParameterError, match="the state for rod 0 is of a robot with other modes or tendon points"):
        batch.set_state(0, states[1])


def test_a_base_that_moves_in_one_lane_and_for_some_steps_leaves_the_others_as_they_are() -> None:
    batch, still = RodBatch(ROBOTS), RodBatch(ROBOTS)
    tension = [5.0, 0.0, 0.0, 0.0]
    rows = np.zeros((4, 3, 25))
    rows[1, 1] = SPIN.row()
    track, other = batch.follow(tension=tension, base=rows, steps=4), still.follow(tension=tension, steps=4)
    assert np.array_equal(track.tip[:, [0, 2]], other.tip[:, [0, 2]])
    assert np.array_equal(track.tip[0], other.tip[0])
    assert np.linalg.norm(track.tip[1:, 1] - other.tip[1:, 1], axis=1).min() > 0.01
    rod = StrainRod(ROBOTS[1])
    state = rod.rest()
    for base in (None, SPIN, None, None):
        state = rod.step(state, rod.loads(tension), base)
    assert equal(batch.state(1), state)
    assert np.allclose(track.tip[3, 1], rod.tip(state)[0], rtol=0.0, atol=1e-14)


def test_what_a_batch_cannot_take_is_refused() -> None:
    with pytest.raises(ParameterError, match="robot 1 has 11 strain modes and 4 tendons, robot 0 has 12 and 4"):
        RodBatch([ROBOTS[0], paper(torsion_modes=2)])
    with pytest.raises(ParameterError, match="robots is empty"):
        RodBatch([])
    batch = RodBatch(ROBOTS[:2])
    changes: tuple[tuple[Any, str], ...] = (
        ({}, "one of them"),
        ({"tension": [1.0] * 3}, r"one of \(4,\), \(2, 4\), \(1, 2, 4\)"),
        ({"tension": [-1.0] * 4}, "cannot push"),
        ({"tension": [np.nan] * 4}, "not finite"),
    )
    for change, said in changes:
        with pytest.raises(ParameterError, match=said):
            batch.step(**change)
    skewed = np.concatenate(([1.0], np.full(9, 0.5), np.zeros(15)))
    for base in (skewed, 2.0 * LIFT.row()):
        with pytest.raises(ParameterError, match="neither zeros nor 1 and a rotation matrix first"):
            batch.step(tension=[1.0] * 4, base=base)
    plain = replace(ROBOTS[0], tendons=tuple(replace(one, stiffness=None) for one in ROBOTS[0].tendons))
    with pytest.raises(ParameterError, match="only be driven by tension"):
        RodBatch([Robot(plain.sections, plain.tendons)]).step(displacement=[0.0] * 4)


def test_a_state_that_is_not_finite_is_reported() -> None:
    batch = RodBatch(ROBOTS[:1])
    batch.rate[0, 0] = np.nan
    with pytest.raises(ConvergenceError, match="not finite"):
        batch.step(tension=[0.0] * 4)
