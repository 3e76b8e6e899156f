"""The rod vibrates as a cantilever beam does, at the frequencies that BDF-alpha makes of the beam's.

Textbook: Blevins, Formulas for Natural Frequency and Mode Shape (Euler-Bernoulli); Huang 1961, J. Appl. Mech. 28, 579
(Timoshenko: with shear and rotary inertia). BDF-alpha: Celaya & Anza 2013, through the equations of the paper.

A mode whose y_t is lambda y is multiplied by z in every time step: (c0 - lambda) z^2 + (c1 + lambda d1) z + c2 = 0.
This gives the frequency and damping that a run must show, and the beam's own lambda from the z of a run.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest
from scipy.integrate import simpson
from scipy.optimize import brentq

from tendond.model import Rod, RodParameters, RodState
from tests.unit.rod.rods import CONSERVATIVE, PAPER, Array

EI = PAPER.youngs_modulus * PAPER.second_moment
BEAM = float(np.sqrt(EI / PAPER.mass_per_length) / PAPER.length**2)
"""Unit of the frequencies [rad/s]."""
BETAS = [float(brentq(lambda b: np.cos(b) + 1.0 / np.cosh(b), *at)) for at in ((1.5, 2.5), (4.0, 5.5), (7.0, 8.5))]
MODES = [0, 1, 2]


def euler_bernoulli(mode: int) -> float:
    """Natural frequency of the slender cantilever [rad/s]."""
    return BEAM * BETAS[mode] ** 2


def timoshenko(mode: int) -> float:
    """The same with shear (on the whole cross-section, as in the rod) and rotary inertia [rad/s]: Huang 1961."""
    r2 = PAPER.second_moment / PAPER.area / PAPER.length**2
    s2 = EI / (PAPER.shear_modulus * PAPER.area) / PAPER.length**2

    def determinant(b: float) -> float:
        root = np.sqrt((r2 - s2) ** 2 + 4.0 / b**2)
        alpha, beta = np.sqrt((root - r2 - s2) / 2.0), np.sqrt((root + r2 + s2) / 2.0)
        even = (2.0 + b**2 * (r2 - s2) ** 2) * np.cosh(b * alpha) * np.cos(b * beta)
        odd = b * (r2 + s2) / np.sqrt(1.0 - b**2 * r2 * s2) * np.sinh(b * alpha) * np.sin(b * beta)
        return float((2.0 + even - odd) / np.cosh(b * alpha))

    return BEAM * float(brentq(determinant, 0.99 * BETAS[mode] ** 2, BETAS[mode] ** 2))


def mode_shape(mode: int, s: Array) -> Array:
    """Mode shape of the slender cantilever, at s [-] from 0 to 1, shape as s."""
    b = BETAS[mode]
    ratio = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    return np.asarray(np.cosh(b * s) - np.cos(b * s) - ratio * (np.sinh(b * s) - np.sin(b * s)))


def bdf(dt: float, alpha: float) -> tuple[float, float, float, float]:
    """c0, c1, c2, d1: y_t(i) = c0 y(i) + c1 y(i-1) + c2 y(i-2) + d1 y_t(i-1)."""
    return (1.5 + alpha) / (dt * (1 + alpha)), -2 / dt, (0.5 + alpha) / (dt * (1 + alpha)), alpha / (1 + alpha)


def multiplier(rate: complex, dt: float, alpha: float) -> complex:
    """z of lambda = rate [1/s]."""
    c0, c1, c2, d1 = bdf(dt, alpha)
    roots = np.roots([c0 - rate, c1 + rate * d1, c2])
    return complex(roots[np.argmax(np.abs(roots))])


def oscillation(omega: float, zeta: float) -> complex:
    """lambda of a damped oscillator [1/s]."""
    return omega * complex(-zeta, np.sqrt(1.0 - zeta**2))


def multipliers(states: list[Array], skipped: int) -> npt.NDArray[np.complex128]:
    """z of the first three modes in a free vibration, from the parts that the modes have in it, shape (3,).

    Each z belongs to a two-step recurrence of these parts; the first steps hold its other root and higher modes.
    """
    s = np.linspace(0.0, 1.0, len(states[0]))
    shapes = np.array([mode_shape(mode, s) for mode in MODES])
    parts = simpson(np.array(states)[skipped:, None, :, 0] * shapes, x=s)
    past = np.hstack([parts[1:-1], parts[:-2]])
    scale = np.abs(past).max(axis=0)
    steps = np.linalg.lstsq(past / scale, parts[2:], rcond=None)[0].T / scale
    found = np.linalg.eigvals(np.vstack([steps, np.eye(3, 6)]))
    ahead = found[found.imag > 0.0]
    lasting = ahead[np.argsort(-np.abs(ahead))][:3]
    return np.asarray(lasting[np.argsort(np.angle(lasting))])


def released(parameters: RodParameters, dt: float, alpha: float, steps: int) -> list[Array]:
    """Shapes [m] of a rod that a force of 1 mN on the tip had bent by 0.3 mm, let go of."""
    rod = Rod(parameters, "rk6", nodes=41, time_step=dt, alpha=alpha, tolerance=1e-10)
    state = rod.solve_static(tip_force=(1e-3, 0.0, 0.0))
    shapes = []
    for _ in range(steps):
        state = rod.step(state)
        shapes.append(state.shape)
    return shapes


def test_the_cantilevers_frequencies_are_those_of_the_page() -> None:
    assert [f"{euler_bernoulli(mode) / (2 * np.pi):.5g}" for mode in MODES] == ["3.7209", "23.319", "65.293"]
    # shear and rotary inertia are 1e-6 of bending, times the square of the wave number
    assert max(abs(timoshenko(mode) / euler_bernoulli(mode) - 1.0) for mode in MODES) < 2e-4


@pytest.mark.parametrize("alpha", [-0.2, -0.5])
def test_the_undamped_rod_vibrates_at_timoshenkos_frequencies(alpha: float) -> None:
    """Once BDF-alpha's own shift and damping are taken off. Mode 3 is 0.3 % of the motion, and less precise for it."""
    c0, c1, c2, d1 = bdf(0.002, alpha)
    z = multipliers(released(CONSERVATIVE, 0.002, alpha, 150), skipped=20)
    rates = (c0 + c1 / z + c2 / z**2) / (1.0 - d1 / z)
    for mode, within in zip(MODES, (1e-7, 1e-6, 1e-5), strict=True):
        assert abs(rates[mode]) == pytest.approx(timoshenko(mode), rel=within)
        assert abs(rates[mode].real) < within * abs(rates[mode])


@pytest.mark.parametrize(
    ("dt", "steps", "shift", "zeta"), [(0.01, 80, "0.9878", "1.4e-03"), (0.002, 150, "0.9995", "1.2e-05")]
)
def test_bdf_alpha_slows_and_damps_the_first_mode_as_its_recurrence_says(
    dt: float, steps: int, shift: str, zeta: str
) -> None:
    expected = np.log(multiplier(1j * timoshenko(0), dt, -0.2)) / dt
    assert f"{expected.imag / timoshenko(0):.4f}" == shift
    assert f"{-expected.real / abs(expected):.1e}" == zeta
    found = np.log(multipliers(released(CONSERVATIVE, dt, -0.2, steps), skipped=20)[0]) / dt
    assert found.imag == pytest.approx(expected.imag, rel=1e-7)
    assert found.real == pytest.approx(expected.real, abs=1e-7 * expected.imag)


def test_bending_damping_damps_the_first_mode_to_zeta_0_627() -> None:
    """Kelvin-Voigt: zeta = Bbt omega / 2EI. It damps no shear, and so holds as far as shear does not count, 1e-5."""
    zeta = PAPER.bending_damping[0] * timoshenko(0) / (2.0 * EI)
    assert f"{zeta:.3f}" == "0.627"
    damped = replace(CONSERVATIVE, bending_damping=PAPER.bending_damping)
    z = multipliers(released(damped, 0.01, -0.2, 40), skipped=10)[0]
    assert np.log(z) == pytest.approx(np.log(multiplier(oscillation(timoshenko(0), zeta), 0.01, -0.2)), rel=2e-5)


def energy(rod: Rod, state: RodState) -> float:
    """Kinetic, elastic and of gravity [J]: Simpson's sum over the nodes."""
    parameters, constants = rod.parameters, rod.parameters.constants()[0]
    strain, u, q, w = np.split(state.levels[state.count % 3, :: len(rod.scheme.weights), :12], 4, axis=1)
    density = constants["rhoA"] * np.sum(q**2, axis=1) + w**2 @ constants["rhoJ"]
    density += strain**2 @ constants["Kse"] + u**2 @ constants["Kbt"]
    density -= 2.0 * constants["rhoA"] * state.shape @ np.array(parameters.gravity)
    return float(simpson(density / 2.0, dx=parameters.length / (rod.nodes - 1)))


def largest_rise(omega: float, zeta: float, dt: float, alpha: float) -> float:
    """Largest relative gain of a damped oscillator's energy in one step of BDF-alpha, at the worst phase [-].

    Where it turns, it loses nothing; and BDF-alpha keeps energy only to the third order of dt.
    """
    rates, modes = np.linalg.eig(np.array([[0.0, omega], [-omega, -2.0 * zeta * omega]]))
    step = (modes * [multiplier(rate, dt, alpha) for rate in rates] @ np.linalg.inv(modes)).real
    return max(0.0, float(np.linalg.norm(step, ord=2)) ** 2 - 1.0)


@pytest.mark.parametrize("dt", [0.01, 0.005, 0.002])
@pytest.mark.parametrize("damping", [0.008, 0.0005])
@pytest.mark.parametrize("drag", [0.1, 0.0])
def test_energy_never_grows_when_the_bent_rod_is_let_go_of(dt: float, damping: float, drag: float) -> None:
    """Energy above that of rest, beyond the rise of the first mode; higher modes are gone before their first turn."""
    rod = Rod(
        replace(PAPER, bending_damping=(damping,) * 3, drag=(drag,) * 3),
        "rk6", nodes=21, time_step=dt, tolerance=1e-10,
    )  # fmt: skip
    rest = energy(rod, rod.solve_static())
    state = rod.solve_static(tip_force=(1.0, 0.5, 0.0))
    above = [energy(rod, state) - rest]
    while state.time < 1.0 and above[-1] > 1e-8 * above[0]:  # below that, Simpson's error shows
        state = rod.step(state)
        above.append(energy(rod, state) - rest)
    allowed = 1.0 + largest_rise(euler_bernoulli(0), damping * euler_bernoulli(0) / (2.0 * EI), dt, -0.2)
    assert max(after / before for before, after in pairwise(above)) <= allowed
    assert above[-1] < 0.3 * above[0]
