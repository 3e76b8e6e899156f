"""Linear models of the strain rod against central differences of its steps, its limit of short steps, and arcs."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain import Robot, StrainRod, StrainState
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.stepping.advance import advance
from tendond.model.strain.stepping.scratch import Loads, scratch_for
from tests.unit.strain.derivatives.programs import driven, pulled, pushed, sheared, tugged, two_sections
from tests.unit.strain.robots import paper

Array = NDArray[np.float64]


def differences(rod: StrainRod, state: StrainState, loads: Loads) -> Array:
    """Fourth-order differences of the step by strains, rates, actuation, force and moment on the tip."""
    n, m, h = rod.modes, len(rod.robot.tendons), rod.time_step
    work = scratch_for(rod.layout)
    node, point = rod.node(rod.robot.length)
    soft = 1e-4 * np.sqrt(work.unit[0] / np.diag(rod.layout.stiffness))
    actuation = np.full(m, 2e-5 if loads.driven.any() else 0.05)
    sizes = np.concatenate((soft, soft / h, actuation, np.full(3, 5e-3), np.full(3, 5e-4)))

    def ahead(change: Array) -> Array:
        q, w = state.strain + change[:n], state.rate + change[n : 2 * n]
        force, moment = loads.force.copy(), loads.moment.copy()
        force[point] += change[2 * n + m : 2 * n + m + 3]
        moment[node] += change[2 * n + m + 3 :]
        tension = loads.tension + change[2 * n : 2 * n + m]
        counts = advance(
            rod.layout, loads._replace(force=force, moment=moment, tension=tension), q, w, h, 1e-12, work, False
        )  # fmt: skip
        assert counts[1:] == (1, 0)
        return np.concatenate((q, w))

    return np.stack(
        [
            (8.0 * (ahead(one) - ahead(-one)) - (ahead(2.0 * one) - ahead(-2.0 * one))) / (12.0 * size)
            for size, one in ((size, size * unit) for size, unit in zip(sizes, np.eye(len(sizes)), strict=True))
        ],
        axis=1,
    )


@pytest.mark.parametrize(
    ("robot", "time_step", "program", "bound"),
    [
        (lambda: paper(), 0.01, pulled, 2e-6),
        (two_sections, 0.01, pushed, 2e-6),
        (sheared, 0.002, tugged, 5e-6),  # 5e-4 N m bend nylon further than the differences are exact
        (lambda: paper(damping=1e-3, drag=50.0), 0.005, driven, 1e-5),  # v |v| limits the differences' order
    ],
    ids=["tensions", "two sections with loads", "shear without damping", "displacements with drag"],
)
def test_the_linear_model_is_the_derivative_of_the_step(
    robot: Callable[[], Robot], time_step: float, program: Callable[[StrainRod, int], Loads], bound: float
) -> None:
    rod = StrainRod(robot(), time_step)
    linear = Linearisation(rod)
    state = rod.rest()
    for k in range(4):
        state = rod.step(state, program(rod, k))
    loads = program(rod, 4)
    found = linear.step(state, loads)
    assert found.analytic
    after = rod.step(state, loads)
    assert np.array_equal(found.state.strain, after.strain)
    assert np.array_equal(found.state.rate, after.rate)
    expected = differences(rod, state, loads)
    n, m = rod.modes, len(rod.robot.tendons)
    soft = 1.0 / np.sqrt(np.diag(rod.layout.stiffness))
    measure = np.concatenate((soft, soft / time_step))
    columns = np.split(expected, np.cumsum([n, n, m, 3]), axis=1)
    ours = (found.a[:, :n], found.a[:, n:], found.b, found.by_force, found.by_moment)
    sizes = (soft, soft / time_step, *(np.ones(k) for k in (m, 3, 3)))
    for mine, theirs, size in zip(ours, columns, sizes, strict=True):
        for half in (slice(0, n), slice(n, 2 * n)):  # strains and rates, in the measure of energy
            error, whole = (np.abs(one[half] * size / measure[half, None]).max() for one in (mine - theirs, theirs))
            assert error < bound * whole


def test_a_step_that_is_split_is_differenced_and_says_so() -> None:
    rod = StrainRod(paper(damping=0.0, drag=0.0), 0.02)
    found = Linearisation(rod).step(rod.rest(), rod.loads([200.0, 0.0, 0.0, 0.0]))
    assert not found.analytic
    assert found.state.steps > 1
    assert np.all(np.isfinite(found.a))
    assert found.b.shape == (2 * rod.modes, 4)


def test_outputs_are_derivatives_of_what_the_rod_reports() -> None:
    rod = StrainRod(two_sections())
    rng = np.random.default_rng(3)
    bends = rod.layout.component < 3
    state = StrainState(
        rng.normal(size=rod.modes) * np.where(bends, 3.0, 1e-3), rng.normal(size=rod.modes) * np.where(bends, 9.0, 1e-2)
    )

    def seen(x: Array) -> tuple[Array, Array]:
        one = StrainState(x[: rod.modes], x[rod.modes :])
        position, turn = rod.tip(one)
        return turn, np.concatenate((position, rod.tip_velocity(one), rod.displacements(one)))

    x = np.concatenate((state.strain, state.rate))
    found = Linearisation(rod).outputs(state)
    turn, _ = seen(x)
    for column, unit in enumerate(np.eye(2 * rod.modes)):
        (up, higher), (down, lower) = seen(x + 1e-6 * unit), seen(x - 1e-6 * unit)
        spun = (up - down) / 2e-6 @ turn.T
        ours = np.concatenate((found.position[:, column], found.velocity[:, column], found.displacement[:, column]))
        assert ours == pytest.approx((higher - lower) / 2e-6, abs=1e-6)
        assert found.rotation[:, column] == pytest.approx((spun[2, 1], spun[0, 2], spun[1, 0]), abs=1e-7)
    assert found.c.shape == (11, 2 * rod.modes)


def test_the_tips_acceleration_is_the_limit_of_short_steps_and_affine_in_the_tensions() -> None:
    """The step itself as its length goes to 0: the change of the tip's velocity over it, extrapolated from two."""
    robot = two_sections(damping=0.0)
    long = StrainRod(robot, 0.01)
    state = long.rest()
    for k in range(4):
        state = long.step(state, pushed(long, k))
    short = StrainRod(robot)
    linear, work = Linearisation(short), scratch_for(short.layout)

    def gained(loads: Loads, h: float) -> Array:
        q, w = state.strain.copy(), state.rate.copy()
        advance(short.layout, loads, q, w, h, 1e-14, work, False)
        return np.asarray((short.tip_velocity(StrainState(q, w)) - short.tip_velocity(state)) / h)

    for loads in (pushed(short, 4), pushed(short, 9)):
        found = linear.tip(state, loads)
        change = 2.0 * gained(loads, 5e-7) - gained(loads, 1e-6)
        assert found.acceleration == pytest.approx(change, abs=1e-3 * float(np.linalg.norm(change)))
        assert found.acceleration == pytest.approx(found.drift + found.input_gain @ loads.tension)
    one, two = linear.tip(state, pushed(short, 4)), linear.tip(state, pushed(short, 9))
    assert one.input_gain == pytest.approx(two.input_gain)
    assert one.drift != pytest.approx(two.drift)  # the force on the tip differs


def test_a_rest_on_an_arc_moves_with_its_tendon_as_the_closed_form_says() -> None:
    """Constant curvature: u = r T / (EI), tip = v3 / u (1 - cos uL, 0, sin uL), v3 = 1 - T / (EA)."""
    rod = StrainRod(paper(gravity=(0.0, 0.0, 0.0)))
    section = rod.robot.sections[0]

    def tip(tension: float) -> Array:
        u, v = 0.02 * tension / section.bending_stiffness[1], 1.0 - tension / section.axial_stiffness
        return v / u * np.array([1.0 - math.cos(0.5 * u), 0.0, math.sin(0.5 * u)])

    loads = rod.loads([20.0, 0.0, 0.0, 0.0])
    found = Linearisation(rod).rest(rod.solve_static(loads), loads)
    assert found.position[:, 0] == pytest.approx((tip(20.01) - tip(19.99)) / 0.02, abs=1e-7)
    assert found.rotation[:, 0] == pytest.approx((0.0, 0.5 * 0.02 / section.bending_stiffness[1], 0.0), abs=1e-6)


@pytest.mark.parametrize("at", [0.2, 0.4])
def test_a_rest_moves_with_a_small_wrench_as_its_derivative_says(at: float) -> None:
    rod = StrainRod(two_sections())
    base = rod.loads([3.0, 2.0])
    state = rod.solve_static(base)
    found = Linearisation(rod, at).rest(state, base)
    for axis, unit in enumerate(np.eye(3)):
        up, down = (
            rod.tip(rod.solve_static(rod.loads([3.0, 2.0], wrenches=[(at, side * 1e-3 * unit, (0.0,) * 3)]), state))[0]
            for side in (1.0, -1.0)
        )
        assert found.by_force[:, axis] == pytest.approx((up - down) / 2e-3, rel=1e-4, abs=1e-6)


def test_a_place_without_a_node_or_at_the_base_is_refused() -> None:
    rod = StrainRod(paper())
    for at, said in ((0.123, "no node at s = 0.123"), (0.0, "beyond the base")):
        with pytest.raises(ParameterError, match=said):
            Linearisation(rod, at)


def test_a_step_that_follows_another_has_the_derivatives_of_one_that_does_not() -> None:
    rod = StrainRod(two_sections())
    first, loads = rod.step(rod.rest(), pushed(rod, 1)), pushed(rod, 2)
    linear, alone = Linearisation(rod), Linearisation(rod)
    before = linear.step(first, loads)
    following, expected = linear.step(before.state, pushed(rod, 3)), alone.step(before.state, pushed(rod, 3))
    assert np.array_equal(following.state.strain, expected.state.strain)
    assert np.array_equal(following.a, expected.a)
    linear.outputs(first)  # works on the same arrays
    again = linear.step(following.state, loads)
    assert np.array_equal(again.b, alone.step(following.state, loads).b)
