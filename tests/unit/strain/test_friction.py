"""Tendons that rub along their paths: capstan in closed form, a plain solver of springs and contacts, and energy."""

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain import Robot, Section, StrainRod, StrainState, Tendon
from tendond.model.strain.analysis.balance import balance_of
from tendond.model.strain.analysis.frames import frames
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.friction.along import tension_along
from tests.reference.capstan import SlowRod
from tests.unit.strain.robots import paper, rubbing, with_modes

Array = NDArray[np.float64]

LENGTH, ARM, SPRING, MU = 0.5, 0.02, 2e4, 0.2
SECTION = Section.round(LENGTH, 1e-3, 190e9, 7850.0, bending_modes=6, torsion_modes=0, stretch_modes=0)
STIFFNESS = 190e9 * math.pi * 1e-12 / 4.0


@cache
def pair(friction: float) -> StrainRod:
    """A wire without weight between two tendons."""
    tendons = tuple(Tendon(LENGTH, (arm, 0.0), SPRING, friction) for arm in (ARM, -ARM))
    return StrainRod(Robot((SECTION,), tendons))


def moved_through(rod: StrainRod, program: Sequence[Sequence[float]]) -> list[StrainState]:
    """Rests on the way through tensions at the servos."""
    states: list[StrainState] = []
    for tensions in program:
        states.append(rod.solve_static(rod.loads(tensions), states[-1] if states else None))
    return states


def way(*corners: tuple[float, float], steps: int = 8) -> list[tuple[float, float]]:
    """Tensions on straight lines between corners, in even steps, the first from zero."""
    found, last = [], (0.0, 0.0)
    for corner in corners:
        found += [tuple(np.asarray(last) + (np.subtract(corner, last)) * k / steps) for k in range(1, steps + 1)]
        last = corner
    return [(float(a), float(b)) for a, b in found]


@cache
def arc() -> StrainRod:
    """A stiff quarter circle, which keeps its shape."""
    curvature = 0.5 * math.pi / LENGTH
    section = replace(
        Section.round(LENGTH, 0.03, 190e9, 7850.0, torsion_modes=0, stretch_modes=0), curvature=(0.0, curvature, 0.0)
    )
    return StrainRod(Robot((section,), (Tendon(LENGTH, (ARM, 0.0), SPRING, 0.3),)))


def test_a_tendon_round_an_arc_has_the_capstans_tension_and_the_wedge_of_its_loop() -> None:
    """T e^(-mu k s) pulled; let out, T' e^(mu k s) as far as that is less: the tendon sticks beyond. Then anew."""
    rod, by_length = arc(), 0.3 * 0.5 * math.pi / LENGTH
    states = moved_through(rod, [(10.0,), (8.0,), (7.0,), (9.0,), (4.0,)])
    s = tension_along(rod, states[0], 0)[0]
    pulled, out = np.exp(-by_length * s), np.exp(by_length * s)
    expected = [10.0 * pulled, np.minimum(8.0 * out, 10.0 * pulled), np.minimum(7.0 * out, 10.0 * pulled)]
    expected.append(np.maximum(expected[-1], 9.0 * pulled))
    expected.append(np.minimum(expected[-1], 4.0 * out))
    for state, tension in zip(states, expected, strict=True):
        np.testing.assert_allclose(tension_along(rod, state, 0)[1][:-1], tension[:-1], rtol=2e-4)
    # displacement of the servo: the stretch, the integral of T / (k L), with the front of the wedge at s*
    front = math.log(10.0 / 8.0) / (2.0 * by_length)
    slid = 8.0 * math.expm1(by_length * front) / by_length
    stuck = 10.0 * (math.exp(-by_length * front) - math.exp(-by_length * LENGTH)) / by_length
    whole = 10.0 * -math.expm1(-by_length * LENGTH) / by_length
    compliance = rod.layout.compliance[:, 0]
    assert states[0].pulls is not None
    assert states[1].pulls is not None
    assert compliance @ states[0].pulls[0, 1:] == pytest.approx(whole / (SPRING * LENGTH), rel=1e-4)
    assert compliance @ states[1].pulls[0, 1:] == pytest.approx((slid + stuck) / (SPRING * LENGTH), rel=5e-3)


@pytest.mark.parametrize("friction", [0.1, 0.2, 0.4])
def test_a_tendon_that_bends_its_own_rod_loses_tension_as_it_bends(friction: float) -> None:
    """T' = -mu T k, EI k = r T: T = T_0 / (1 + mu r T_0 s / EI), pulled; with a minus sign, let out."""
    rod = pair(friction)
    states = moved_through(rod, [(20.0, 0.0), *((pull, 0.0) for pull in np.linspace(18.0, 4.0, 8))])
    for state, pull, sign in ((states[0], 20.0, 1.0), (states[-1], 4.0, -1.0)):
        s, tension = tension_along(rod, state, 0)
        growth = sign * friction * ARM * pull / STIFFNESS
        np.testing.assert_allclose(tension, pull / (1.0 + growth * s), rtol=1e-3)
        angle = sign * math.log1p(growth * LENGTH) / friction
        assert rod.displacements(state)[0] == pytest.approx(ARM * angle, rel=1e-3)
        assert tension[-1] / tension[0] == pytest.approx(math.exp(-sign * friction * angle), rel=1e-3)


def test_a_pair_pulled_to_and_fro_moves_as_springs_and_contacts_do() -> None:
    """One tendon after the other, each once passive: `tests.reference.capstan`, 24 cells, converged to 1e-5."""
    program = way((10.0, 3.0), (20.0, 3.0), (10.0, 3.0), (10.0, 8.0), (15.0, 8.0))
    plain, rod = SlowRod(LENGTH, STIFFNESS, (ARM, -ARM), SPRING, MU, 24), pair(MU)
    largest = lost = 0.0
    for tensions, state in zip(program, moved_through(rod, program), strict=True):
        plain.pull(tensions)
        largest, lost = max(largest, plain.bend), lost + state.friction_work
        assert lost == pytest.approx(plain.lost, rel=0.02)
        assert rod.displacements(state)[0] == pytest.approx(ARM * plain.bend, abs=4e-3 * ARM * largest)
        for tendon in range(2):
            s, found = tension_along(rod, state, tendon)
            expected = np.interp(s[1:-1], plain.places, plain.tension[tendon])
            np.testing.assert_allclose(found[1:-1], expected, atol=0.02 * max(tensions))
            assert state.pulls is not None
            stretch = rod.layout.compliance[:, tendon] @ state.pulls[tendon, 1:]
            assert stretch == pytest.approx(plain.tension[tendon].mean() / SPRING, rel=5e-3)


def test_a_passive_tendon_resists_and_the_rod_does_not_come_all_the_way_back() -> None:
    states = moved_through(pair(MU), way((10.0, 3.0), (20.0, 3.0), (10.0, 3.0)))
    up, down = (pair(MU).displacements(states[k])[0] for k in (7, 23))
    free = moved_through(pair(0.0), way((10.0, 3.0)))[-1]
    assert down > pair(0.0).displacements(free)[0] > up
    assert tension_along(pair(MU), states[15], 1)[1][-1] > 3.0  # drawn out of its servo


def test_twice_the_friction_is_twice_the_exponent() -> None:
    ends = {}
    for friction in (0.1, 0.2):
        rod = StrainRod(replace(arc().robot, tendons=(replace(arc().robot.tendons[0], friction=friction),)))
        ends[friction] = tension_along(rod, rod.solve_static(rod.loads([10.0])), 0)[1][-1] / 10.0
    assert ends[0.2] == pytest.approx(ends[0.1] ** 2, rel=1e-6)
    assert ends[0.1] == pytest.approx(math.exp(-0.1 * 0.5 * math.pi), rel=1e-4)


@pytest.mark.parametrize("route", ["helical", "converging", "parallel"])
def test_in_space_the_tension_falls_by_the_bend_of_the_path_as_it_is_seen(route: str) -> None:
    """Angles between chords of the path, from positions alone, of a loaded arm of two sections; weight aslant."""
    tendons = {
        "helical": Tendon.helical(0.4, 0.008, 0.75, friction=MU),
        "converging": Tendon.converging(0.4, (0.012, 0.002), (0.004, -0.004), friction=MU),
        "parallel": Tendon(0.4, (0.01, 0.004), friction=MU),
    }
    half = Section.round(0.2, 1e-3, 190e9, 8000.0, torsion_modes=2, bending_modes=4)
    rod = StrainRod(Robot((half, half), (tendons[route],), (), (1.0, -9.0, 2.0)))
    state = rod.solve_static(rod.loads([20.0], tip_force=(0.1, -0.2, 0.05)))
    s, tension = tension_along(rod, state, 0)
    at = np.linspace(0.0, 0.4, 801)
    placed = frames(rod, state, at)
    local = np.array([(*rod.robot.tendons[0].at(float(one)), 0.0, 1.0) for one in at])
    chords = np.diff(np.einsum("kij,kj->ki", placed, local)[:, :3], axis=0)
    chords /= np.linalg.norm(chords, axis=1)[:, None]
    steps = np.arctan2(
        np.linalg.norm(np.cross(chords[:-1], chords[1:]), axis=1), np.sum(chords[:-1] * chords[1:], axis=1)
    )
    bend = np.concatenate(([0.0], np.cumsum(steps)))
    expected = 20.0 * np.exp(-MU * np.interp(s, 0.5 * (at[1:] + at[:-1]), bend))
    np.testing.assert_allclose(tension, expected, rtol=4e-3)
    assert expected[-1] < 0.98 * 20.0


@pytest.mark.parametrize(("damping", "friction"), [(0.008, 0.1), (1e-4, 0.2), (0.0, 0.5)])
def test_friction_takes_energy_away_and_gives_none_however_fast_the_motion(damping: float, friction: float) -> None:
    rod = StrainRod(rubbing(paper(damping=damping, drag=0.0), friction))
    state = rod.solve_static(rod.loads([20.0, 5.0, 5.0, 5.0]))
    fed = stored = 0.0
    for k in range(60):
        loads = rod.loads([20.0 + 10.0 * math.sin(0.2 * k), 5.0 + 3.0 * math.sin(0.07 * k), 5.0, 5.0])
        after = rod.step(state, loads)
        assert after.friction_work >= 0.0
        if after.steps == 1:
            balance = balance_of(rod, state, after, loads)
            assert balance.lost > -1e-12
            stored = max(stored, balance.after.total)
            fed += after.friction_work
        assert after.damped == 0
        state = after
    assert fed > 0.01 * stored


def test_an_undamped_rod_loses_its_swing_by_friction() -> None:
    kept = []
    for friction in (0.0, 0.3):
        rod = StrainRod(rubbing(paper(damping=0.0, drag=0.0, gravity=(0.0, 0.0, 0.0)), friction), 0.005)
        loads = rod.loads([10.0] * 4)
        state = rod.solve_static(rod.loads([10.0] * 4, tip_force=(1.0, 0.0, 0.0)), rod.solve_static(loads))
        start = rod.energy(state)
        for _ in range(200):
            state = rod.step(state, loads)
        kept.append(rod.energy(state) / start)
    assert kept[1] < 0.5 * kept[0]


def test_hardly_any_friction_is_none() -> None:
    robot = with_modes(paper(), 4)
    tips = []
    for friction in (0.0, 1e-9):
        rod = StrainRod(rubbing(robot, friction))
        state = rod.solve_static(rod.loads([5.0, 4.0, 1.0, 1.0]))
        for k in range(10):
            state = rod.step(state, rod.loads([5.0 + k, 4.0, 1.0, 1.0]))
        tips.append(rod.tip(state)[0])
    assert np.linalg.norm(tips[1] - tips[0]) < 1e-8


def test_a_rest_is_found_again_from_itself() -> None:
    """Slack or taut: where nothing is left to be found, rounding must not be searched for it."""
    robot = with_modes(paper(), 4)
    tendons = tuple(replace(one, stiffness=SPRING) for one in robot.tendons)
    rod = StrainRod(rubbing(replace(robot, tendons=tendons), MU))
    for ends in (-1.0, -0.002, 0.001):
        loads = rod.loads(displacement=[ends] * 4)
        state = rod.solve_static(loads)
        for _ in range(3):
            again = rod.solve_static(loads, state)
            assert np.linalg.norm(rod.tip(again)[0] - rod.tip(state)[0]) < 1e-9
            state = again


def test_a_servo_that_holds_its_place_keeps_the_tension_that_friction_left() -> None:
    rod = pair(MU)
    drive = [0.02, -0.015]
    state = rod.solve_static(rod.loads(displacement=drive))
    slack = rod.solve_static(rod.loads(displacement=[0.02, -0.05]))
    assert slack.pulls is not None
    assert slack.pulls[1].tolist() == [0.0] * len(slack.pulls[1])
    for _ in range(3):
        after = rod.solve_static(rod.loads(displacement=drive), state)
        assert state.pulls is not None
        assert after.pulls is not None
        np.testing.assert_allclose(after.pulls, state.pulls, rtol=1e-6, atol=1e-9)
        state = after
    assert state.pulls is not None
    at_servo = rod.displacements(state)[0] + rod.layout.compliance[:, 0] @ state.pulls[0, 1:]
    assert at_servo == pytest.approx(0.02, abs=1e-12)
    tension = tension_along(rod, state, 0)[1]
    assert tension[-1] / tension[0] == pytest.approx(math.exp(-MU * rod.displacements(state)[0] / ARM), rel=1e-3)


def test_derivatives_hold_the_ratios_of_the_tensions() -> None:
    rod = StrainRod(rubbing(paper(), MU))
    linear = Linearisation(rod)
    state = rod.solve_static(rod.loads([20.0, 1.0, 1.0, 1.0]))
    loads = rod.loads([25.0, 1.0, 1.0, 1.0])
    found, real = linear.step(state, loads), rod.step(state, loads)
    np.testing.assert_allclose(found.state.strain, real.strain, atol=1e-7)
    more = rod.step(state, rod.loads([25.01, 1.0, 1.0, 1.0]))  # the tendon slides on, with all ratios as they are
    slope = (more.strain - real.strain) / 0.01
    assert np.linalg.norm(found.b[: rod.modes, 0] - slope) < 0.03 * np.linalg.norm(slope)
    with pytest.raises(ParameterError, match="tendon 0 has friction and is driven by displacement"):
        linear.step(state, rod.loads(displacement=[0.01, -0.02, -0.02, -0.02]))
