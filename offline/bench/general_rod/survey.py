"""Survey of the general rod: robots, steps and loads at random, to find a step that fails or energy that appears.

Each draw is a robot of one to three sections from steel to silicone, 0.05 to 2 m long, damping ratio 0 to 10 %, time
step 0.1 to 20 ms, that is loaded in one step - by tension, by displacement, by a force or a moment on the tip, up to
720 degrees of bend - or released from an equilibrium, and then left alone. The seed and its number
identify a draw: a failure is found again by `tendond bench rod --survey 1 --first NUMBER`.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tendond.model.errors import ConvergenceError
from tendond.model.strain import Body, Robot, Section, StrainRod, StrainState, Tendon
from tendond.model.strain.stepping.scratch import Loads

LOADED_STEPS, FREE_STEPS = 12, 13

MATERIALS = {"steel": (200e9, 7850.0), "nitinol": (60e9, 6450.0), "nylon": (2e9, 1150.0), "silicone": (5e5, 1100.0)}
"""Young's modulus [Pa] and density [kg/m^3]."""

KINDS = ("tension", "displacement", "push", "moment", "release")

FULL_BEND = 4.0 * math.pi
"""Bend under the largest load [rad]."""

GROWTH = 1e-7
"""Largest gain of energy in a free step, of the energy in play: ten times the tolerance of a step."""


@dataclass(frozen=True)
class Draw:
    """A robot, what is done to it, and its damping ratio."""

    number: int
    kind: str
    material: str
    ratio: float
    rod: StrainRod
    loads: Loads


@dataclass(frozen=True)
class Outcome:
    """Outcome of a draw.

    Attributes:
        draw: which. failed: what failed, empty if nothing. split: steps that were split. iterations: Newton's, the max.
            of a step. growth: largest gain of energy in a free step, as a part of the energy in play.
    """

    draw: Draw
    failed: str
    split: int
    damped: int
    iterations: int
    growth: float


def draw(number: int, seed: int = 1) -> Draw:
    """Return the draw of that number."""
    rng = np.random.default_rng((seed, number))
    count = int(rng.integers(1, 4))
    length = 10.0 ** rng.uniform(math.log10(0.05), math.log10(2.0))
    material = str(rng.choice(list(MATERIALS)))
    modulus, density = MATERIALS[material]
    radius = length * 10.0 ** rng.uniform(-3.0, -2.2) * (4.0 if modulus < 1e8 else 1.0)
    ratio = float(rng.choice([0.0, 10.0 ** rng.uniform(-4.0, -1.0)]))
    plain = Section.round(length, radius, modulus, density)
    bending, area = plain.bending_stiffness[0], plain.mass_per_length
    omega = 1.8751**2 * math.sqrt(bending / (area * length**4))
    damped = 2.0 * ratio / omega
    parts = rng.uniform(0.6, 1.4, count)
    lengths = length * parts / parts.sum()
    sections = tuple(
        Section.round(
            float(one), radius * (1.0 - 0.15 * index), modulus, density,
            bending_damping=(damped * bending * (1.0 - 0.15 * index) ** 4,) * 3,
        )
        for index, one in enumerate(lengths)
    )  # fmt: skip
    arm = length * 10.0 ** rng.uniform(-2.0, -1.2)
    ends = np.cumsum(lengths)
    stretched = bending / (arm**2 * length) * 10.0 ** rng.uniform(0.0, 3.0)
    tendons = tuple(
        Tendon(float(end), (arm * math.cos(angle), arm * math.sin(angle)), stretched)
        for index, end in enumerate(ends)
        for angle in 2.0 * math.pi * np.arange(3) / 3.0 + 0.3 * index
    )
    mass = area * length
    tip = float(mass * 10.0 ** rng.uniform(-2.0, 1.0))
    size = (0.4 * tip * (3.0 * radius) ** 2,) * 3
    bodies = (Body(float(ends[-1]), tip, size, (0.0, 0.0, 3.0 * radius)),) if rng.random() < 0.4 else ()
    gravity = tuple(9.81 * rng.normal(size=3)) if rng.random() < 0.7 else (0.0, 0.0, 0.0)
    time_step = 10.0 ** rng.uniform(-4.0, math.log10(0.02))
    rod = StrainRod(Robot(sections, tendons, bodies, gravity), time_step)
    kind = str(rng.choice(KINDS))
    bend = FULL_BEND * 10.0 ** rng.uniform(-2.0, 0.0)
    pulled = np.where(rng.random(len(tendons)) < 0.5, rng.random(len(tendons)), 0.0)
    direction = rng.normal(size=3)
    direction /= np.linalg.norm(direction)
    if kind == "tension" or (kind == "release" and rng.random() < 0.5):
        loads = rod.loads(tension=pulled * bend * bending / (arm * length))
    elif kind == "displacement":
        loads = rod.loads(displacement=(2.0 * pulled - 0.5) * bend * arm)
    elif kind == "moment":
        loads = rod.loads(wrenches=[(length, (0.0, 0.0, 0.0), bend * bending / length * direction)])
    else:
        loads = rod.loads(tip_force=2.0 * bend * bending / length**2 * direction)
    return Draw(number, kind, material, ratio, rod, loads)


def run(one: Draw) -> Outcome:
    """Run a draw."""
    rod, loads, free = one.rod, one.loads, one.rod.loads()
    state, split, damped, iterations, growth = rod.rest(), 0, 0, 0, 0.0
    elastic = 0.0
    try:
        if one.kind == "release":
            state = rod.solve_static(loads)
        else:
            for _ in range(LOADED_STEPS):
                state = rod.step(state, loads)
                split += state.steps > 1
                damped += state.damped
                iterations = max(iterations, state.iterations)
        energy = rod.energy(state)
        scale = _in_play(rod, state)
        for _ in range(FREE_STEPS):
            state = rod.step(state, free)
            split += state.steps > 1
            damped += state.damped
            iterations = max(iterations, state.iterations)
            after = rod.energy(state)
            growth = max(growth, (after - energy - _hidden(rod, scale)) / max(scale, 1e-300))
            energy = after
            elastic = max(elastic, energy)
    except ConvergenceError as error:
        return Outcome(one, str(error), split, damped, iterations, growth)
    failed = "" if growth < GROWTH else f"energy grows by {growth:.1e} in a free step"
    if not (np.all(np.isfinite(state.strain)) and np.all(np.isfinite(state.rate))):
        failed = "not finite"
    return Outcome(one, failed, split, damped, iterations, growth)


def _hidden(rod: StrainRod, energy: float) -> float:
    """Return what rounding may add to the energy in a step [J]: positions that are off by it over the step's time.

    Moves of nanometres in a tenth of a millisecond, of a robot of half a metre, have six digits.
    """
    momentum = math.sqrt(2.0 * energy * float(rod.layout.mass.sum()))
    return 10.0 * momentum * float(np.finfo(float).eps) * rod.robot.length / rod.time_step


def _in_play(rod: StrainRod, state: StrainState) -> float:
    """Kinetic and elastic energy, and that of the weight over the length [J]."""
    still = StrainState(state.strain, np.zeros_like(state.rate))
    kinetic = rod.energy(state) - rod.energy(still)
    elastic = 0.5 * float(state.strain @ rod.layout.stiffness @ state.strain)
    weight = float(rod.layout.mass.sum() * np.linalg.norm(rod.layout.gravity)) * rod.robot.length
    return kinetic + elastic + weight


def survey(
    count: int, first: int = 0, seed: int = 1, progress: Callable[[Outcome], None] | None = None
) -> list[Outcome]:
    """Run `count` draws from `first` on; return those that failed. `progress` is called with every outcome."""
    bad = []
    for number in range(first, first + count):
        outcome = run(draw(number, seed))
        if outcome.failed:
            bad.append(outcome)
        if progress is not None:
            progress(outcome)
    return bad
