"""The margin for a mass on the tip: the gains that it admits, and the real loop."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from math import ceil, log

import numpy as np

from tendond.daemon.control.gains import law_rates, observer_gains, unknown_tip_mass
from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.reference.planar import PLANES
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.errors import ConvergenceError
from tendond.model.estimation.margin import min_stiffness_ratio
from tendond.model.estimation.poles import FeedbackGains, UnknownPlant, loop_poles
from tendond.model.rods.selection import model_rod
from tendond.offline.logs.metrics import SETTLED
from tendond.offline.robustness.unlike import unlike
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

RATES = (100.0, 250.0)
"""Rates of the loop [Hz]."""

DELAYS = ((0, 0), (1, 0), (2, 0), (3, 0), (0, 1))
"""Delay of the poses that is configured, and the delay on top of it that is not [cycles]."""

IDLE_SECONDS, TRACKING_SECONDS, LAST_SECONDS = 1.0, 12.0, 2.0
ARMING_SECONDS = 20.0
"""Maximum time of the rest and the probe before tracking begins [s]."""

RIPPLE_MAX = 0.2e-3
"""Largest ripple of any coordinate of the true tip, peak to peak, in the last seconds of a run [m]."""


@dataclass(frozen=True)
class GainsRow:
    """The gains of a rate and a delay.

    Attributes:
        rate: rate of the loop [Hz]. delay: delay of a pose [cycles].
        integral, proportional, derivative: admitted [1/s, -, s].
        bare, loaded: decay of the slowest motion of the linear loop without a mass, and of the worst with the largest,
            one cycle of delay more than configured [1/s].
    """

    rate: float
    delay: int
    integral: float
    proportional: float
    derivative: float
    bare: float
    loaded: float


@dataclass(frozen=True)
class LoopRow:
    """A run of the real loop in lockstep on a plant that its model does not know.

    Attributes:
        law: name. rate: [Hz]. mass: mass on the tip [kg]. stiffness: E of the plant over that of the model.
        delay_known, delay_unknown: delay of the poses as configured in the observer, and beyond that [cycles].
        settling: time of tracking to stay within `SETTLED` of the target's x [s]; none if it does not.
        ripple: see `RIPPLE_MAX` [m]. reason: reason of a fault.
        passes: it tracks, has settled, and the ripple is small.
    """

    law: str
    rate: float
    mass: float
    stiffness: float
    delay_known: int
    delay_unknown: int
    settling: float | None
    ripple: float | None
    reason: str
    passes: bool


def at_rate(config: RigConfig, rate: float, delay: int) -> RigConfig:
    """`config` at another rate [Hz] and delay [cycles]."""
    loop = config.loop.model_copy(update={"period": 1.0 / rate})
    return config.model_copy(
        update={"loop": loop, "observer": config.observer.model_copy(update={"delay": delay / rate})}
    )


def gains_rows(config: RigConfig) -> Iterator[GainsRow]:
    """Yield the gains that the margin admits, by rate and delay."""
    rod = model_rod(config).parameters
    for rate, delay in product(RATES, range(4)):
        changed = at_rate(config, rate, delay)
        gains, mass = observer_gains(changed, rod), unknown_tip_mass(changed, rod)
        used = FeedbackGains(gains.integral, gains.proportional, gains.derivative, gains.innovation_time, 1.0)

        def decay(plant: UnknownPlant, rate: float = rate, delay: int = delay, used: FeedbackGains = used) -> float:
            poles = [
                abs(
                    loop_poles(rod, 1.0 / rate, config.rod.alpha, used, law_rates(config), plant, delay, ahead=ahead)[0]
                )
                for ahead in (False, True)
            ]
            return -log(max(poles)) * rate

        loaded = [
            UnknownPlant(mass, stiffness, delay=delay + late)
            for stiffness in (min_stiffness_ratio(rod, mass), 1.15)
            for late in (0, 1)
        ]
        yield GainsRow(
            rate,
            delay,
            gains.integral,
            gains.proportional,
            gains.derivative,
            decay(UnknownPlant(delay=delay)),
            min(map(decay, loaded)),
        )


def loop_cases(config: RigConfig, *, short: bool = False) -> list[LoopRow]:
    """List the runs without their results; `short`: the corners of one rate."""
    rod, parts = model_rod(config).parameters, (0.0, 1.0) if short else (0.0, 0.2, 0.5, 1.0)
    stiffnesses = (0.85, 1.15) if short else (0.85, 1.0, 1.15)
    delays = DELAYS[3:] if short else DELAYS

    def largest(rate: float, known: int) -> float:
        return unknown_tip_mass(at_rate(config, rate, known), rod)

    return [
        LoopRow(law, rate, round(part * largest(rate, known), 6), stiffness, known, unknown, None, None, "", False)
        for law in LAWS
        for rate in (RATES[:1] if short else RATES)
        for part in parts
        for stiffness in stiffnesses
        for known, unknown in delays
    ]


def run_loop(config: RigConfig, case: LoopRow) -> LoopRow:
    """Run a case, and what came of it."""
    values = at_rate(config, case.rate, case.delay_known).model_dump()
    values["control"]["law"] = case.law
    rod = unlike(config.rod, case.stiffness).model_dump()
    period = 1.0 / case.rate
    values["simulator"] = {
        "period": period,
        "rod": rod,
        "weight": {"mass": case.mass},
        "mocap": {"latency": (case.delay_known + case.delay_unknown) * period},
    }
    values["vicon"] = values["servo"] = None
    rig = check_config(values, str(case))
    idle, tracking = ceil(IDLE_SECONDS * case.rate), ceil(TRACKING_SECONDS * case.rate)
    tips, target, reason = [], 0.0, ""
    try:
        for watched in watched_loop(rig, idle + ceil(ARMING_SECONDS * case.rate) + tracking, {idle: ControlAction.ARM}):
            if watched.record.mode is Mode.TRACKING:
                tips.append(watched.truth.position)
                target = watched.record.reference.target[PLANES[rig.control.plane][0]]
            elif tips or watched.record.mode is Mode.FAULT:
                reason = watched.record.reason
                break
            if len(tips) == tracking:
                break
    except ConvergenceError as error:
        reason = f"the plant has no solution: {error}"
    if len(tips) < tracking:
        return _with(case, None, None, reason or "tracking did not begin")
    tip = np.array(tips)
    ripple = float(np.max(np.ptp(tip[-ceil(LAST_SECONDS * case.rate) :], axis=0)))
    away = np.flatnonzero(np.abs(tip[:, PLANES[rig.control.plane][0]] - target) > SETTLED * abs(target))
    settling = (int(away[-1]) + 1) / case.rate if len(away) else 0.0
    return _with(case, settling if settling < TRACKING_SECONDS - LAST_SECONDS else None, ripple, reason)


def _with(case: LoopRow, settling: float | None, ripple: float | None, reason: str) -> LoopRow:
    passes = settling is not None and ripple is not None and ripple < RIPPLE_MAX and not reason
    return replace(case, settling=settling, ripple=ripple, reason=reason, passes=passes)


def loop_rows(config: RigConfig, cases: Sequence[LoopRow], processes: int) -> Iterator[LoopRow]:
    """Run the cases, and yield their results in order."""
    if processes == 1:
        yield from (run_loop(config, case) for case in cases)
        return
    with ProcessPoolExecutor(processes) as pool:
        yield from pool.map(run_loop, [config] * len(cases), cases)
