"""A base that moves, against textbooks on accelerated and rotating frames, and on a cantilever that is shaken."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain import Body, Robot, Section, StrainRod, StrainState
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.describe.base import Base
from tests.unit.strain.robots import paper

Array = NDArray[np.float64]


def turn(angle: float) -> Array:
    """Rotation about y."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def run(rod: StrainRod, state: StrainState, base: Base, steps: int, tension: list[float] | None = None) -> StrainState:
    """Follow a base whose accelerations are constant."""
    for k in range(steps):
        state = rod.step(state, rod.loads(tension), base.after(k * rod.time_step))
    return state


def in_base(rod: StrainRod, state: StrainState) -> Array:
    """Tip in the frame of the base [m]."""
    position, _ = rod.tip(state)
    return position if state.base is None else state.base.rotation.T @ (position - state.base.position)


def test_a_base_that_accelerates_is_one_at_rest_under_other_gravity() -> None:
    """The principle of equivalence: in the base's frame gravity is g - a, step by step."""
    lift = np.array([2.0, -3.0, 1.5])
    accelerated = StrainRod(paper(drag=0.0))
    other = StrainRod(paper(drag=0.0, gravity=tuple(np.array((-9.81, 0.0, 0.0)) - lift)))
    start = accelerated.solve_static(accelerated.loads())
    ours, theirs = start, start
    base = Base(acceleration=lift)
    for k in range(60):
        ours = accelerated.step(ours, accelerated.loads([8.0, 0.0, 0.0, 0.0]), base.after(0.01 * k))
        theirs = other.step(theirs, other.loads([8.0, 0.0, 0.0, 0.0]))
        assert in_base(accelerated, ours) == pytest.approx(other.tip(theirs)[0], abs=1e-9)
    assert ours.base is not None
    assert ours.base.position == pytest.approx(0.5 * lift * 0.36)


def test_a_base_that_is_driven_evenly_changes_nothing() -> None:
    """Galilei's: at constant velocity the rod moves as at rest."""
    driven, still = StrainRod(paper(drag=0.0)), StrainRod(paper(drag=0.0))
    base = Base(velocity=np.array([1.0, 2.0, -3.0]))
    ours = theirs = still.solve_static(still.loads())
    for k in range(40):
        ours = driven.step(ours, driven.loads([5.0, 0.0, 0.0, 0.0]), base.after(0.01 * k))
        theirs = still.step(theirs, still.loads([5.0, 0.0, 0.0, 0.0]))
    assert in_base(driven, ours) == pytest.approx(still.tip(theirs)[0], abs=1e-9)
    assert driven.tip_velocity(ours) == pytest.approx(still.tip_velocity(theirs) + base.velocity, abs=1e-7)


def test_a_rest_hangs_as_the_pose_of_its_base_says() -> None:
    """Gravity in the base's frame is R' g."""
    rod, rotation = StrainRod(paper()), turn(0.7)
    tilted = StrainRod(paper(gravity=tuple(rotation.T @ np.array((-9.81, 0.0, 0.0)))))
    base = Base(rotation, np.array([0.1, 0.2, 0.3]), velocity=np.ones(3))
    found = rod.solve_static(rod.loads([10.0, 0.0, 0.0, 0.0]), base=base)
    expected = tilted.solve_static(tilted.loads([10.0, 0.0, 0.0, 0.0]))
    assert in_base(rod, found) == pytest.approx(tilted.tip(expected)[0], abs=1e-9)
    assert rod.step(found, rod.loads([10.0, 0.0, 0.0, 0.0])).strain == pytest.approx(found.strain, abs=1e-6)
    assert rod.frequencies(found, rod.loads([10.0, 0.0, 0.0, 0.0])) == pytest.approx(
        tilted.frequencies(expected, tilted.loads([10.0, 0.0, 0.0, 0.0])), rel=1e-6
    )
    own = rod.solve_static(rod.loads())
    assert own.base is None
    assert rod.tip(own)[0] == pytest.approx(StrainRod(paper()).tip(own)[0])


def test_a_base_that_spins_across_the_rod_stretches_it() -> None:
    """A bar along s under centrifugal load rho A w^2 (s + u): E u'' + rho w^2 (s + u) = 0, u(0) = u'(L) = 0."""
    section = Section.round(
        0.4, 3e-3, 1e7, 1100.0, bending_damping=(1e-2,) * 3, stretch_modes=3, shear_damping=(1e3,) * 3
    )
    rod, rate = StrainRod(Robot((section,)), 0.002), 20.0
    base = Base(spin=np.array([0.0, rate, 0.0]))
    state = rod.step(rod.rest(), rod.loads(), base)
    for k in range(1, 1500):
        state = rod.step(state, rod.loads(), base.after(k * rod.time_step))
    longer = in_base(rod, state)[2] - 0.4
    beta = math.sqrt(1100.0 / 1e7) * rate
    assert longer == pytest.approx(math.tan(beta * 0.4) / beta - 0.4, rel=2e-3)
    assert in_base(rod, state)[:2] == pytest.approx((0.0, 0.0), abs=2e-3 * 0.4)


def test_a_spin_about_the_rods_axis_bends_it_by_what_is_off_the_axis() -> None:
    """A mass on a light rod, off its axis by e, spun at w: deflection e w^2 / (w0^2 - w^2), as of Jeffcott's rotor."""
    section = Section.round(0.3, 1e-3, 60e9, 1.0, bending_damping=(2e-3,) * 3)
    mass, off = 0.05, 1e-3
    rod = StrainRod(Robot((section,), (), (Body(0.3, mass, offset=(off, 0.0, 0.0)),)), 0.005)
    natural = math.sqrt(3.0 * section.bending_stiffness[0] / (mass * 0.3**3))
    rate = 0.5 * natural
    state = run(rod, rod.rest(), Base(spin=np.array([0.0, 0.0, rate])), 1200)
    ratio = rate**2 / natural**2
    assert in_base(rod, state)[0] == pytest.approx(off * ratio / (1.0 - ratio), rel=2e-2)
    assert abs(in_base(rod, state)[1]) < 0.05 * off


def test_a_shaken_cantilever_moves_as_its_modes_say() -> None:
    """Base excitation: the sum of phi_i(L) gamma_i W^2 / (w_i^2 - W^2 + 2 j z_i w_i W) times the base's motion.

    A. Erturk, D. J. Inman, J. Vib. Acoust. 130 (2008), equation 28; modes of Blevins (1979), table 8-1.
    """
    section = Section.round(0.5, 1e-3, 190e9, 7850.0)
    omega = 1.875104**2 * math.sqrt(section.bending_stiffness[0] / (section.mass_per_length * 0.5**4))
    ratio = 0.05
    damped = Section.round(
        0.5, 1e-3, 190e9, 7850.0, bending_damping=(2.0 * ratio / omega * section.bending_stiffness[0],) * 3
    )
    time_step = 2.0 * math.pi / omega / 200.0
    rod = StrainRod(Robot((damped,)), time_step)
    amplitude, tips = 1e-5, []
    state = rod.rest()
    count = 200 * 20
    for k in range(count):
        phase = k * 2.0 * math.pi / 200.0
        middle = phase + math.pi / 200.0
        base = Base(
            position=np.array([amplitude * math.sin(phase), 0.0, 0.0]),
            velocity=np.array([amplitude * omega * math.cos(phase), 0.0, 0.0]),
            acceleration=np.array([-amplitude * omega**2 * math.sin(middle), 0.0, 0.0]),
        )
        state = rod.step(state, rod.loads(), base)
        tips.append(in_base(rod, state)[0])
    phases = 2.0 * math.pi / 200.0 * np.arange(count - 199, count + 1)
    found = 2.0 / 200.0 * np.sum(np.array(tips[-200:]) * np.exp(-1j * phases)) * 1j
    expected = 0.0j
    for root, sigma in ((1.875104, 0.734096), (4.694091, 1.018467), (7.854757, 0.999224)):
        own = (root / 1.875104) ** 2 * omega
        end = 2.0 * (-1.0 if root > 4.0 and root < 5.0 else 1.0)
        gamma = 2.0 * sigma / root  # integral of the mode over L
        damping = ratio * own / omega
        expected += end * gamma * omega**2 / (own**2 - omega**2 + 2j * damping * own * omega)
    assert abs(found / amplitude - expected) < 0.03 * abs(expected)


def test_a_base_that_moves_and_stops_leaves_what_energy_it_put_in_and_no_more() -> None:
    rod = StrainRod(paper(damping=0.0, drag=0.0), 0.005)
    state = rod.solve_static(rod.loads())
    rest = rod.energy(state)
    speeding = Base(acceleration=np.array([0.0, 4.0, 0.0]))
    slowing = replace(speeding.after(0.1), acceleration=-speeding.acceleration)
    for k in range(40):
        base = speeding.after(0.005 * k) if k < 20 else slowing.after(0.005 * (k - 20))
        state = rod.step(state, rod.loads(), base)
    assert state.base is not None
    assert state.base.velocity == pytest.approx(np.zeros(3), abs=1e-12)
    energies = []
    for _ in range(300):
        state = rod.step(state, rod.loads())
        energies.append(rod.energy(state))
    assert energies[0] > rest + 1e-3
    assert np.diff(energies).max() < 1e-7 * (energies[0] - rest)


def test_a_base_that_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match="not a rotation matrix"):
        Base(2.0 * np.eye(3))
    with pytest.raises(ParameterError, match="velocity must be finite"):
        Base(velocity=np.array([math.nan, 0.0, 0.0]))
    rod = StrainRod(paper())
    moved = rod.step(rod.rest(), rod.loads(), Base(velocity=np.ones(3)))
    linear = Linearisation(rod)
    for ask in (linear.step, linear.tip, linear.rest, linear.stability):
        with pytest.raises(ParameterError, match="base moves"):
            ask(moved, rod.loads())
    with pytest.raises(ParameterError, match="base moves"):
        linear.outputs(moved)
