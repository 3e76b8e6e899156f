"""Prints the figures that are known of the paper's robot beside what this reference makes of them.

Run from the top folder: python -m tests.reference.check. Takes some minutes.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, log, pi, sin, sqrt

import numpy as np
from scipy.optimize import brentq

from tests.reference.balance import imbalance
from tests.reference.converged import converged_static
from tests.reference.rod import ReferenceRod, vector
from tests.reference.schemes import euler, runge_kutta
from tests.reference.solution import Solution
from tests.reference.solver import ReferenceModel

WEIGHTLESS = vector(0.0, 0.0, 0.0)
NODES = 200


@dataclass(frozen=True)
class Figure:
    """One figure: as known, with the digits that it is known to, and as computed here, in the same unit."""

    name: str
    known: str
    computed: float

    @property
    def agrees(self) -> bool:
        """Equal to the last digit of the known figure, or below it where it is a bound."""
        if self.known.startswith("<"):
            return self.computed < float(self.known[1:])
        mantissa, _, exponent = self.known.partition("e")
        decimals = len(mantissa.partition(".")[2])
        unit = 10.0 ** (int(exponent or 0) - decimals)
        return abs(self.computed - float(self.known)) <= 0.5001 * unit

    def __str__(self) -> str:
        return f"{self.name:<72} {self.known:>9} {self.computed:>12.6g}{'' if self.agrees else '  DIFFERS'}"


def pulled_without_gravity() -> Iterator[Figure]:
    """T1 alone, no gravity, the paper's Euler scheme."""
    model = ReferenceModel(ReferenceRod(gravity=WEIGHTLESS), euler(NODES))
    for tension, x, z, millimetres in ((10.0, "0.1607", "0.4639", "13.41"), (43.0, "0.3447", "0.0456", "57.67")):
        solution = model.solve_static(vector(tension, 0.0, 0.0, 0.0))
        name = f"static, no gravity, T1 = {tension:.0f} N: "
        yield Figure(name + "tip x [m]", x, solution.tip.position[0])
        yield Figure(name + "tip y [m]", "0", solution.tip.position[1])
        yield Figure(name + "tip z [m]", z, solution.tip.position[2])
        yield Figure(name + "tendon 1 [mm]", millimetres, 1e3 * solution.tendon_displacements[0])


def constant_curvature() -> Iterator[Figure]:
    """Parallel tendons without gravity bend the rod to an arc."""
    rod = ReferenceRod(gravity=WEIGHTLESS)
    for difference, x, z, error in ((4.0, "66.611", "494.027", "0.34"), (20.0, "287.805", "363.179", "1.69")):
        tensions = vector(1.0 + difference, 1.0, 1.0, 1.0)
        v3 = 1.0 - tensions.sum() / (rod.youngs_modulus * rod.area)
        u = 0.02 * difference / (rod.youngs_modulus * rod.second_moment)
        exact = v3 / u * vector(1.0 - cos(u * rod.length), 0.0, sin(u * rod.length))
        name = f"arc, dT = {difference:.0f} N: "
        yield Figure(name + "formula, tip x [mm]", x, 1e3 * exact[0])
        yield Figure(name + "formula, tip z [mm]", z, 1e3 * exact[2])
        for route, known, tip in (
            ("converged", "< 1e-9", converged_static(rod, tensions).tip_position),
            ("Euler, 200 nodes", error, ReferenceModel(rod, euler(NODES)).solve_static(tensions).tip.position),
            ("RK4, 40 steps", "< 1e-5", ReferenceModel(rod, runge_kutta(40)).solve_static(tensions).tip.position),
        ):
            yield Figure(f"{name}{route}, off the formula [mm]", known, 1e3 * float(np.linalg.norm(tip - exact)))


def euler_series() -> Iterator[Figure]:
    """First order: the tip under gravity and tensions [5, 4, 1, 1] by number of nodes, and its limit."""
    rod, tensions, name = ReferenceRod(), vector(5.0, 4.0, 1.0, 1.0), "static, gravity, T = [5, 4, 1, 1] N, "
    for nodes, x in ((50, "36.60"), (100, "37.84"), (200, "38.45"), (400, "38.76"), (800, "38.91")):
        solution = ReferenceModel(rod, euler(nodes)).solve_static(tensions)
        yield Figure(f"{name}Euler, {nodes} nodes: tip x [mm]", x, 1e3 * solution.tip.position[0])
    yield Figure(name + "converged: tip x [mm]", "39.06", 1e3 * converged_static(rod, tensions).tip_position[0])


def elastica() -> Iterator[Figure]:
    """Transverse dead load P at the tip: Euler's elastica, without shear or stretch; so a very slender rod."""
    rod, none = ReferenceRod(radius=1e-4, gravity=WEIGHTLESS), np.zeros(4)
    for load, across, along in ((1.0, "0.30172", "0.05643"), (2.0, "0.49346", "0.16064"), (5.0, "0.71379", "0.38763")):
        force = vector(load * rod.Kbt[0, 0] / rod.length**2, 0.0, 0.0)
        converged = converged_static(rod, none, tip_force_world=force).tip_position
        fine = ReferenceModel(rod, runge_kutta(40)).solve_static(none, tip_force_world=force).tip.position
        for route, tip in (("converged", converged), ("RK4, 40 steps", fine)):
            name = f"elastica, P L^2 / EI = {load:.0f}, {route}: "
            yield Figure(name + "w/L", across, tip[0] / rod.length)
            yield Figure(name + "1 - x/L", along, 1.0 - tip[2] / rod.length)


def two_shapes() -> Iterator[Figure]:
    """Tip x = 340 mm under gravity, with little and with much tension; and the farthest x, which lies between."""
    model = ReferenceModel(ReferenceRod(), euler(NODES))
    shapes = [model.solve_static(vector(20.0, 0.0, 0.0, 0.0))]
    while shapes[-1].tensions[0] < 46.0:
        shapes.append(model.solve_static(shapes[-1].tensions + vector(2.0, 0.0, 0.0, 0.0), start=shapes[-1]))
    x = np.array([shape.tip.position[0] for shape in shapes])
    top = int(np.argmax(x))
    parabola = np.polynomial.Polynomial.fit(np.arange(-1.0, 2.0), x[top - 1 : top + 2], 2)
    yield Figure("static, gravity: farthest tip x [mm]", "362", 1e3 * float(parabola(parabola.deriv().roots()[0])))

    near, far = np.flatnonzero(np.diff(np.sign(x - 0.340)))
    for place, z, millimetres, tension in ((near, "264", "36", None), (far, "40", "58.6", "43.8")):
        shape = with_tip_at(model, 0.340, shapes[place], shapes[place + 1])
        name = f"static, gravity, x = 340 mm, {'near' if place == near else 'far'} shape: "
        yield Figure(name + "tip z [mm]", z, 1e3 * shape.tip.position[2])
        yield Figure(name + "tendon 1 [mm]", millimetres, 1e3 * shape.tendon_displacements[0])
        if tension:
            yield Figure(name + "T1 [N]", tension, shape.tensions[0])


def with_tip_at(model: ReferenceModel, x: float, low: Solution, high: Solution) -> Solution:
    """The static shape with this tip x [m] and a T1 between those of two others."""

    def shape(tension: float) -> Solution:
        return model.solve_static(vector(tension, 0.0, 0.0, 0.0), start=low)

    def error(tension: float) -> float:
        return float(shape(tension).tip.position[0]) - x

    return shape(float(brentq(error, float(low.tensions[0]), float(high.tensions[0]), xtol=1e-4)))


def tension_step() -> Iterator[Figure]:
    """Step of tension from rest under gravity: T1 = 43 N from i = 0 on, the first solved step."""
    model, tensions = ReferenceModel(ReferenceRod(), euler(NODES)), vector(43.0, 0.0, 0.0, 0.0)
    solution = model.solve_static(np.zeros(4))
    yield Figure("static, gravity, T = 0: tip x [mm]", "-27.94", 1e3 * solution.tip.position[0])
    known = {2: "0.0828", 10: "0.3611"}
    began = time.perf_counter()
    for i in range(81):
        solution = model.step(solution, tensions)
        if i in known:
            yield Figure(f"dynamic, T1 = 43 N stepped: tip x at i = {i} [m]", known[i], solution.tip.position[0])
    name = f"dynamic, T1 = 43 N stepped, i = {i} ({(time.perf_counter() - began) / (i + 1):.2f} s a step): "
    yield Figure(name + "tip x [m]", "0.3440", solution.tip.position[0])
    yield Figure("the same: tendon 1 [mm]", "57.48", 1e3 * solution.tendon_displacements[0])
    rest = model.solve_static(tensions)
    yield Figure("static, gravity, T1 = 43 N: tip x [m]", "0.3440", rest.tip.position[0])
    yield Figure("the same: tendon 1 [mm]", "57.48", 1e3 * rest.tendon_displacements[0])


def bdf_alpha(rod: ReferenceRod, omega: float) -> complex:
    """z: what one step multiplies an oscillation y_t = i omega y [rad/s] by."""
    roots = np.roots([rod.c0 - 1j * omega, rod.c1 + 1j * omega * rod.d1, rod.c2])
    return complex(roots[np.argmax(np.abs(roots))])


def frequency_and_damping(z: complex, dt: float) -> tuple[float, float]:
    """f [Hz] and zeta [-] of an oscillation that is multiplied by z in every step dt [s]."""
    decay, omega = log(abs(z)) / dt, float(np.angle(z)) / dt
    return omega / (2.0 * pi), -decay / sqrt(decay**2 + omega**2)


def vibration() -> Iterator[Figure]:
    """Small vibration: slender cantilever by the textbook, BDF-alpha on one oscillator, and the rod let go of."""
    rod = ReferenceRod()
    EI = rod.youngs_modulus * rod.second_moment
    omegas = [beta**2 * sqrt(EI / (rod.rhoA * rod.length**4)) for beta in (1.87510407, 4.69409113, 7.85475744)]
    for number, (omega, known) in enumerate(zip(omegas, ("3.7209", "23.319", "65.293"), strict=True), start=1):
        yield Figure(f"cantilever, mode {number}: f [Hz]", known, omega / (2.0 * pi))
    yield Figure("cantilever, mode 1 with Bbt: zeta", "0.627", rod.bending_damping[0] * omegas[0] / (2.0 * EI))
    for dt, ratio, known in ((0.01, "0.9878", "0.0014"), (0.002, "0.9996", "3e-5")):
        f, zeta = frequency_and_damping(bdf_alpha(ReferenceRod(dt=dt), omegas[0]), dt)
        yield Figure(f"BDF-alpha, dt {dt}, mode 1: f/f0", ratio, 2.0 * pi * f / omegas[0])
        yield Figure(f"BDF-alpha, dt {dt}, mode 1: zeta", known, zeta)

    free = ReferenceRod(bending_damping=np.zeros(3), drag=np.zeros(3), gravity=WEIGHTLESS)
    model = ReferenceModel(free, runge_kutta(10))
    solution = model.solve_static(np.zeros(4), tip_force_world=vector(0.001, 0.0, 0.0))
    x = []
    for _ in range(80):
        solution = model.step(solution, np.zeros(4))
        x.append(solution.tip.position[0])
    late, lags = np.array(x[20:]), 4
    past = np.column_stack([late[lags - lag : len(late) - lag] for lag in range(1, lags + 1)])
    recurrence = np.linalg.lstsq(past, late[lags:], rcond=None)[0]
    slowest = min((z for z in np.roots([1.0, *-recurrence]) if z.imag > 0.0), key=lambda z: float(np.angle(z)))
    f, zeta = frequency_and_damping(complex(slowest), free.dt)
    yield Figure("undamped rod let go of, RK4, 10 steps, dt 0.01: f/f0", "0.9878", 2.0 * pi * f / omegas[0])
    yield Figure("undamped rod let go of, RK4, 10 steps, dt 0.01: zeta", "0.0014", zeta)


def momentum() -> Iterator[Figure]:
    """All loads at once, in motion: what is left of the balance of momentum goes with the fourth power of ds."""
    tensions, force, moment = vector(20.0, 12.0, 1.0, 1.5), vector(0.1, 0.2, 0.1), vector(0.01, 0.02, 0.01)
    for steps, known in ((10, "3e-5"), (40, "1e-7")):
        model = ReferenceModel(ReferenceRod(shear_damping=np.full(3, 5.0)), runge_kutta(steps))
        solution = model.solve_static(vector(5.0, 2.0, 1.0, 1.5))
        for _ in range(6):
            solution = model.step(solution, tensions, force, moment, force, moment)
        name = f"in motion, RK4, {steps} steps: "
        linear, angular = imbalance(solution)
        yield Figure(name + "momentum left over [-]", f"< {known}", linear)
        yield Figure(name + "angular momentum left over [-]", f"< {known}", angular)


def main() -> None:
    """Print all figures."""
    groups = (
        pulled_without_gravity,
        constant_curvature,
        euler_series,
        elastica,
        two_shapes,
        tension_step,
        vibration,
        momentum,
    )
    print(f"{'figure':<72} {'known':>9} {'computed':>12}")
    differing = 0
    for group in groups:
        for figure in group():
            print(figure, flush=True)
            differing += not figure.agrees
    print(f"{differing} figures differ")


if __name__ == "__main__":
    main()
