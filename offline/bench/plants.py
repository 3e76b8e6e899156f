"""The simulator's own plant beside the one in MuJoCo: shapes at rest, frequencies, and the loop on both."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from tendond.drivers.simulator.lockstep import closed_loop
from tendond.drivers.simulator.mujoco_rod import MujocoRod
from tendond.drivers.simulator.rods import plant_robot, plant_rod, plant_solver
from tendond.model.strain.rod import StrainRod
from tendond.offline.logs.metrics import metrics, tracking_of
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.requests import ControlAction

PARTS = (0.0, 0.1, 0.25, 0.5, 0.75)
"""Tensions of the shapes at rest, as parts of limits.tension_max [-]."""

FREQUENCIES = 3
"""Number of frequencies of bending."""

ARM_SECONDS = 0.5
RUN_SECONDS = 4.0
"""Times of arming, and of a run from then on [s]."""

LAWS = ("backstepping", "sliding_mode")
SHAPE_PERCENT, FREQUENCY_PERCENT, ERROR_MM = 1.5, 3.0, 1.0
"""Goals: distance of the tips at rest, of the length [%]; of the frequencies [%]; steady error on MuJoCo [mm].

A joint of the chain bends the tendons more sharply than the rod does, see `drivers.mujoco.chain.SITE_GAP`: by half a
percent in tension at the sharpest bends here, which the tip shows most where it is bent by half a turn. The chain's
frequencies converge by the square of its links' length: with 30 links the third is 2.4 % low."""


@dataclass(frozen=True)
class Row:
    """A quantity of both plants.

    Attributes:
        quantity: its name. unit: of it. own, mujoco: its value; none where there is none.
        apart: the difference; of shapes the distance of the tips [mm]. meets: whether it meets its goal.
    """

    quantity: str
    unit: str
    own: float | None
    mujoco: float | None
    apart: float | None
    meets: bool


def compare(config: RigConfig, laws: Sequence[str] = LAWS) -> Iterator[Row]:
    """Yield the rows of the table, those of the shapes first.

    Args:
        config: rig; its [simulator] describes both plants. laws: those whose runs are compared.

    Raises:
        ModelError: a robot that a plant cannot be, or that has no solution.
        LogError: a run that does not track.
        ModuleNotFoundError: MuJoCo is not installed.
    """
    yield from _shapes(config)
    yield from _frequencies(config)
    for law in laws:
        yield from _runs(config, law)


def _with_plant(config: RigConfig, solver: Literal["shooting", "general", "mujoco"]) -> RigConfig:
    section = config.simulator.model_copy(update={"solver": solver})
    return config.model_copy(update={"simulator": section})


def _own(config: RigConfig) -> Literal["shooting", "general"]:
    """Return the solver of the own plant: as configured, or the one that the robot needs where MuJoCo is."""
    solver = plant_solver(config.simulator.model_copy(update={"solver": None}))
    assert solver != "mujoco"
    return "general" if config.simulator.solver == "general" else solver


def _shapes(config: RigConfig) -> Iterator[Row]:
    plants = [plant_rod(_with_plant(config, name).simulator, config.simulator.period) for name in ("general", "mujoco")]
    states = [None, None]
    count = plants[0].parameters.tendon_count
    for part in PARTS:
        tensions = np.zeros(count)
        tensions[config.control.agonist] = part * config.limits.tension_max
        states = [rod.solve_static(tensions, start=state) for rod, state in zip(plants, states, strict=True)]
        own, other = (rod.tip(state).position for rod, state in zip(plants, states, strict=True))
        apart = float(np.linalg.norm(own - other))
        axis = {"x": 0, "y": 1}[config.control.plane[0]]
        yield Row(
            f"tip at rest, {tensions.max():g} N, {'xy'[axis]}",
            "mm",
            1e3 * float(own[axis]),
            1e3 * float(other[axis]),
            1e3 * apart,
            apart <= SHAPE_PERCENT / 100.0 * plants[0].parameters.length,
        )


def _frequencies(config: RigConfig) -> Iterator[Row]:
    own = StrainRod(
        replace(plant_robot(config.simulator), gravity=(0.0, 0.0, 0.0), tendons=()), config.simulator.period
    )
    chain = MujocoRod(_with_plant(config, "mujoco").simulator, config.simulator.period)
    bending = own.frequencies(own.rest(), own.loads())[: 2 * FREQUENCIES : 2]
    hertz = chain.frequencies()[: 2 * FREQUENCIES : 2] / (2.0 * math.pi)
    for order, (one, other) in enumerate(zip(bending.tolist(), hertz.tolist(), strict=True), 1):
        meets = abs(other / one - 1.0) <= FREQUENCY_PERCENT / 100.0
        yield Row(f"frequency {order} of bending", "Hz", one, other, other - one, meets)


def _runs(config: RigConfig, law: str) -> Iterator[Row]:
    control = config.control.model_copy(update={"law": law})
    chosen = config.model_copy(update={"control": control})
    arm, cycles = (round(one / config.loop.period) for one in (ARM_SECONDS, ARM_SECONDS + RUN_SECONDS))
    found = []
    for solver in (_own(config), "mujoco"):
        rig = _with_plant(chosen, solver)
        records = list(closed_loop(rig, cycles, {arm: ControlAction.ARM}))
        found.append(metrics(tracking_of(records, rig, f"{law} on {solver}")))
    own, other = found
    for name, unit, one, two in (
        ("settling", "s", own.settling_s, other.settling_s),
        ("overshoot", "%", own.overshoot_percent, other.overshoot_percent),
        ("steady error", "mm", own.steady_state_error_mm, other.steady_state_error_mm),
    ):
        apart = None if one is None or two is None else two - one
        meets = two is not None and (name != "steady error" or two <= ERROR_MM)
        yield Row(f"{law}, {name}", unit, one, two, apart, meets)
