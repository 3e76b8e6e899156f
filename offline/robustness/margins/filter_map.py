"""The margin of the loop with the filter over the workspace: rates, delays, bends, and plants unlike the model."""

import math
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from itertools import product

from tendond.daemon.control.estimation.estimator import MASS_SHARE
from tendond.daemon.control.gains import usual_tip_mass
from tendond.daemon.control.setup import CycleSetup
from tendond.model.errors import ParameterError
from tendond.model.estimation.margin import STIFFNESS_RANGE, UNKNOWN_DELAY
from tendond.model.rods.general import GeneralRod
from tendond.offline.robustness.margins.filter_loop import gain_margin, law_poles, radius
from tendond.offline.robustness.margins.filter_parts import model_parts, plant_parts, resting_tensions
from tendond.offline.robustness.margins.loop import at_rate
from tendond.schemas.config.rig import RigConfig, check_config

LAWS = ("backstepping", "sliding_mode", "sensitivity")
"""Laws whose derivatives are those of one decision: a law that plans over a horizon has a state of its own."""

RATES = (50.0, 100.0, 250.0, 500.0)
"""Rates of the loop [Hz]."""

DELAYS = (0.0, 0.02)
"""Delays of the poses, as configured [s]."""

BENDS = (0.2, 1.1, 2.0)
"""Bends of the arm, turns of its tip [rad]."""


@dataclass(frozen=True)
class FilterCase:
    """A rest of the loop. law: name. rate: [Hz]. delay: of the poses, as configured [s]. bend: of the arm [rad]."""

    law: str
    rate: float
    delay: float
    bend: float


@dataclass(frozen=True)
class FilterRow:
    """Poles of the loop at a rest.

    Attributes:
        case: the rest. own: largest pole of law and model alone; above 1, the law is unstable there by itself.
        nominal: largest pole of the loop on a plant like the model, sampled at the rate.
        worst: that of the worst plant, on a delay as configured or a cycle more; decay: of the slowest motion then,
            negative where it grows [1/s].
        mass, stiffness, late: mass on its tip [kg], E over that of the model, and unknown delay [cycles].
        margin: factor that the filter's gain may have on the worst plant; 1: unstable.
    """

    case: FilterCase
    own: float
    nominal: float
    worst: float
    decay: float
    mass: float
    stiffness: float
    late: int
    margin: float

    @property
    def passes(self) -> bool:
        """True if no motion grows on any plant."""
        return self.worst < 1.0


def filter_config(config: RigConfig) -> RigConfig:
    """Return a configuration with the filter, on the general rod."""
    values = config.model_dump()
    values["control"]["solver"], values["observer"]["kind"] = "general", "kalman"
    return check_config(values, "the configuration, with the filter")


def filter_cases(*, short: bool = False) -> list[FilterCase]:
    """List the rests; `short`: those of one rate and delay, and two bends."""
    some = (LAWS, RATES[1:2] if short else RATES, DELAYS[1:2] if short else DELAYS, BENDS[::2] if short else BENDS)
    return [FilterCase(*one) for one in product(*some)]


def filter_row(config: RigConfig, case: FilterCase) -> FilterRow:
    """Return the poles at a rest.

    Raises:
        ParameterError: the arm cannot be bent so far.
        TendondError: the configuration has no filter, or the arm no rest.
    """
    cycles = round(case.delay * case.rate)
    values = at_rate(config, case.rate, cycles).model_dump()
    values["control"]["law"] = case.law
    values["reference"] = {"kind": "minimum_jerk", "angle": case.bend}
    rig = check_config(values, str(case))
    setup = CycleSetup.from_config(rig)
    rod = setup.rod
    if not isinstance(rod, GeneralRod):
        raise ParameterError("the margin of the filter needs the general rod")
    tensions = resting_tensions(setup, case.bend)
    model = model_parts(setup, tensions)
    mass = MASS_SHARE * usual_tip_mass(rig, rod.parameters)
    found = []
    for load, stiffness in product((0.0, 0.5 * mass, mass), STIFFNESS_RANGE):
        plant = plant_parts(rod, load, stiffness, tensions)
        found += [
            (radius(model, plant, cycles, late), load, stiffness, late, plant) for late in range(UNKNOWN_DELAY + 1)
        ]
    worst = max(found, key=lambda one: one[0])
    own = law_poles(model)
    return FilterRow(
        case=case,
        own=float(max((abs(one) for one in own), default=0.0)),
        nominal=radius(model, plant_parts(rod, 0.0, 1.0, tensions), cycles, 0),
        worst=worst[0], decay=-math.log(worst[0]) * case.rate,
        mass=worst[1], stiffness=worst[2], late=worst[3],
        margin=gain_margin(model, [(plant, late) for _, _, _, late, plant in found[-3:]], cycles),
    )  # fmt: skip


def filter_rows(config: RigConfig, cases: Sequence[FilterCase], processes: int) -> Iterator[FilterRow]:
    """Yield the rows of the rests in order."""
    if processes == 1:
        yield from (filter_row(config, case) for case in cases)
        return
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(partial(filter_row, config), cases)
