"""Prints the figures that are known of the paper's robot beside what this reference makes of them.

Run from the top folder: python -m tests.reference.check. Takes some minutes. Exit status 1 if a figure differs.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, log, pi, sin, sqrt

import numpy as np
from scipy.optimize import brentq

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
        """Equal to the last digit of the known figure."""
        mantissa, _, exponent = self.known.partition("e")
        decimals = len(mantissa.partition(".")[2])
        unit = 10.0 ** (int(exponent or 0) - decimals)
        return abs(self.computed - float(self.known)) <= 0.5001 * unit

    def __str__(self) -> str:
        verdict = "" if self.agrees else f"  DIFFERS by {self.computed - float(self.known):.3g}"
        return f"{self.name:<66} {self.known:>9} {self.computed:>12.6g}{verdict}"


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
        converged = converged_static(rod, tensions).tip_position
        yield Figure(
            name + "converged, off the formula [mm]", "0.000000", 1e3 * float(np.linalg.norm(converged - exact))
        )
        coarse = ReferenceModel(rod, euler(NODES)).solve_static(tensions).tip.position
        yield Figure(
            name + "Euler, 200 nodes, off the formula [mm]", error, 1e3 * float(np.linalg.norm(coarse - exact))
        )
        fine = ReferenceModel(rod, runge_kutta(40)).solve_static(tensions).tip.position
        yield Figure(name + "RK4, 40 steps, off the formula [mm]", "0.0000", 1e3 * float(np.linalg.norm(fine - exact)))


def euler_series() -> Iterator[Figure]:
    """First order: the tip under gravity and tensions [5, 4, 1, 1] by number of nodes, and its limit."""
    rod, tensions = ReferenceRod(), vector(5.0, 4.0, 1.0, 1.0)
    for nodes, x in ((50, "36.60"), (100, "37.84"), (200, "38.45"), (400, "38.76"), (800, "38.91")):
        solution = ReferenceModel(rod, euler(nodes)).solve_static(tensions)
        yield Figure(
            f"static, gravity, T = [5, 4, 1, 1] N, Euler, {nodes} nodes: tip x [mm]", x, 1e3 * solution.tip.position[0]
        )
    limit = converged_static(rod, tensions).tip_position[0]
    yield Figure("static, gravity, T = [5, 4, 1, 1] N, converged: tip x [mm]", "39.06", 1e3 * limit)


def elastica() -> Iterator[Figure]:
    """Transverse dead load P at the tip, textbook values for a rod that only bends."""
    rod = ReferenceRod(gravity=WEIGHTLESS)
    for load, across, along in ((1.0, "0.30172", "0.05643"), (2.0, "0.49346", "0.16064"), (5.0, "0.71379", "0.38763")):
        force = vector(load * rod.youngs_modulus * rod.second_moment / rod.length**2, 0.0, 0.0)
        tip = converged_static(rod, np.zeros(4), tip_force_world=force).tip_position / rod.length
        fine = (
            ReferenceModel(rod, runge_kutta(40)).solve_static(np.zeros(4), tip_force_world=force).tip.position
            / rod.length
        )
        for route, (x, _, z) in (("converged", tip), ("RK4, 40 steps", fine)):
            yield Figure(f"elastica, P L^2 / EI = {load:.0f}, {route}: w/L", across, x)
            yield Figure(f"elastica, P L^2 / EI = {load:.0f}, {route}: 1 - x/L", along, 1.0 - z)


def two_shapes() -> Iterator[Figure]:
    """Tip x = 340 mm under gravity, with little and with much tension; and the farthest x between."""
    model, last = ReferenceModel(ReferenceRod(), euler(NODES)), None
    shapes: list[Solution] = []
    for tension in np.arange(20.0, 46.0, 2.0):
        last = model.solve_static(vector(tension, 0.0, 0.0, 0.0), start=last)
        shapes.append(last)
    x = np.array([shape.tip.position[0] for shape in shapes])
    around = slice(int(np.argmax(x)) - 1, int(np.argmax(x)) + 2)
    parabola = np.polynomial.Polynomial.fit([shape.tensions[0] for shape in shapes[around]], x[around], 2)
    yield Figure("static, gravity: farthest tip x [mm]", "362", 1e3 * float(parabola(parabola.deriv().roots()[0])))

    for name, z, millimetres, begin in (("near", "264", "36", 0), ("far", "40", "58.6", len(shapes) - 2)):
        start = shapes[begin]

        def beyond(tension: float, start: Solution = start) -> float:
            solution = model.solve_static(vector(tension, 0.0, 0.0, 0.0), start=start)
            return float(solution.tip.position[0]) - 0.340

        crossing = int(np.flatnonzero((x[:-1] - 0.34) * (x[1:] - 0.34) < 0.0)[0 if begin == 0 else -1])
        tension = brentq(beyond, *(shape.tensions[0] for shape in shapes[crossing : crossing + 2]), xtol=1e-4)
        shape = model.solve_static(vector(tension, 0.0, 0.0, 0.0), start=start)
        yield Figure(f"static, gravity, x = 340 mm, {name} shape: tip z [mm]", z, 1e3 * shape.tip.position[2])
        yield Figure(
            f"static, gravity, x = 340 mm, {name} shape: tendon 1 [mm]",
            millimetres,
            1e3 * shape.tendon_displacements[0],
        )
        if name == "far":
            yield Figure("static, gravity, x = 340 mm, far shape: T1 [N]", "43.8", tension)


def tension_step() -> Iterator[Figure]:
    """From rest under gravity, T1 = 43 N from i = 0 on; i = 0 is the first solved step."""
    model, tensions = ReferenceModel(ReferenceRod(), euler(NODES)), vector(43.0, 0.0, 0.0, 0.0)
    solution = model.solve_static(np.zeros(4))
    yield Figure("static, gravity, T = 0: tip x [mm]", "-27.94", 1e3 * solution.tip.position[0])
    known = {2: "0.0828", 10: "0.3611"}
    began = time.perf_counter()
    for i in range(121):
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
    for _ in range(90):
        solution = model.step(solution, np.zeros(4))
        x.append(solution.tip.position[0])
    late = np.array(x[30:])
    recurrence = np.linalg.lstsq(np.column_stack([late[1:-1], late[:-2]]), late[2:], rcond=None)[0]
    z = np.roots([1.0, -recurrence[0], -recurrence[1]])
    f, zeta = frequency_and_damping(complex(z[np.argmax(z.imag)]), free.dt)
    yield Figure("the rod undamped and let go of, RK4, 10 steps, dt 0.01: f/f0", "0.9878", 2.0 * pi * f / omegas[0])
    yield Figure("the rod undamped and let go of, RK4, 10 steps, dt 0.01: zeta", "0.0014", zeta)


def main() -> int:
    """Print all figures; 1 if one differs."""
    groups = (pulled_without_gravity, constant_curvature, euler_series, elastica, two_shapes, tension_step, vibration)
    print(f"{'figure':<66} {'known':>9} {'computed':>12}")
    differing = 0
    for group in groups:
        for figure in group():
            print(figure, flush=True)
            differing += not figure.agrees
    print(f"{differing} figures differ")
    return 1 if differing else 0


if __name__ == "__main__":
    sys.exit(main())
