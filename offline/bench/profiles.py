"""Both laws on each profile of the simulator, in lockstep: the time that the servos' real speed costs."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.offline.logs.metrics import SETTLED
from tendond.schemas.assumed_rig import RESOLUTION
from tendond.schemas.config.presets import PROFILES
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

LAWS = ("backstepping", "sliding_mode")
ARMED_AT = 10
CYCLES = 1000
LAST = 100
"""Cycles of which the error is taken."""

HEADING = (
    "| profile | law | tendon travel [mm] | at full speed [s] | reference arrives [s] | settled [s]"
    " | max. error after [mm] | error [mm] | tension variation [N] | jerks [mm] | reversals [1/s] |\n"
    "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


@dataclass(frozen=True)
class ProfileRow:
    """Measures of a law on a profile; the tip is the simulated one.

    Attributes:
        profile, law: names.
        travel_mm: pull of the agonist's end, from the straight rod [mm].
        full_speed: time that the travel takes at the displacement rate [s]; none without servos.
        arrival: time at which the reference reaches the target [s].
        settled: time after which x stays within 5 % of the target, impacts included [s]; none: never.
        worst_mm: largest error of x after the reference's arrival and one second [mm].
        error_mm: mean error of x in the end [mm].
        variation: total variation of the agonist's commanded tension until one second after the arrival [N].
        jerks_mm: root mean square of the second difference of its commanded displacement, as long [mm].
        reversals: direction changes of the commanded displacement over the same cycles [1/s].
        fault: reason; empty without one.
    """

    profile: str
    law: str
    travel_mm: float
    full_speed: float | None
    arrival: float
    settled: float | None
    worst_mm: float
    error_mm: float
    variation: float
    jerks_mm: float
    reversals: float
    fault: str

    @property
    def cells(self) -> tuple[str, ...]:
        """Cells of the row in the Markdown table."""
        return (
            self.profile,
            self.law,
            f"{self.travel_mm:.1f}",
            "-" if self.full_speed is None else f"{self.full_speed:.2f}",
            f"{self.arrival:.2f}",
            f"never: {self.fault}" if self.settled is None else f"{self.settled:.2f}",
            f"{self.worst_mm:.1f}",
            f"{self.error_mm:.1f}",
            f"{self.variation:.0f}",
            f"{self.jerks_mm:.3f}",
            f"{self.reversals:.1f}",
        )


def reversals(displacement: Array) -> int:
    """Count the reversals of a servo that follows `displacement` [m], shape (k,)."""
    steps = np.sign(np.diff(np.round(displacement / RESOLUTION)))
    steps = steps[steps != 0.0]
    return int(np.count_nonzero(np.diff(steps)))


def profile_config(profile: str, law: str, *, sampled: bool | None = None) -> RigConfig:
    """Return a profile's configuration with a law; `sampled` instead of its own `control.sampled`."""
    config = parse_config(PROFILES[profile], f"profile '{profile}'")
    changes = {"law": law} if sampled is None else {"law": law, "sampled": sampled}
    return config.model_copy(update={"control": config.control.model_copy(update=changes)})


def run_profile(profile: str, law: str, config: RigConfig | None = None) -> ProfileRow:
    """Ten seconds of a profile under a law; `config` instead of the profile's own.

    Raises:
        ConvergenceError: the plant has no solution.
    """
    config = profile_config(profile, law) if config is None else config
    period = config.loop.period
    trace = list(watched_loop(config, CYCLES, {ARMED_AT: ControlAction.ARM}))
    part = [one for one in trace if one.record.mode is Mode.TRACKING]
    last = trace[-1].record
    x = np.array([one.truth.position[0] for one in part])
    target = last.reference.target[0]
    error = np.abs(x - target)
    outside = np.flatnonzero(error > SETTLED * target)
    settled = (int(outside[-1]) + 1) * period if outside.size else 0.0
    travel = last.command.displacement[config.control.agonist]
    driven = config.simulator.drive == "displacement"
    arrival = CycleSetup.from_config(config).selection.reference.arrival
    busy = part[: round((arrival + 1.0) / period)]
    tension = np.array([one.record.command.tension[config.control.agonist] for one in busy])
    displacement = np.array([one.record.command.displacement[config.control.agonist] for one in busy])
    return ProfileRow(
        profile=profile,
        law=law,
        travel_mm=1e3 * travel,
        full_speed=travel / config.with_own_rates().limits.displacement_rate if driven else None,
        arrival=arrival,
        settled=settled if last.mode is Mode.TRACKING and settled < len(x) * period else None,
        worst_mm=1e3 * float(error[round((arrival + 1.0) / period) :].max()),
        error_mm=1e3 * abs(float(x[-LAST:].mean()) - target),
        variation=float(np.abs(np.diff(tension)).sum()),
        jerks_mm=1e3 * float(np.sqrt(np.mean(np.diff(displacement, 2) ** 2))),
        reversals=reversals(displacement) / (len(busy) * period),
        fault=last.reason if last.mode is Mode.FAULT else "",
    )


def table() -> str:
    """Write the Markdown table: every profile with both laws, and `rig` with the laws as written, too."""
    rows = [run_profile(profile, law) for profile in PROFILES for law in LAWS]
    for law in LAWS:
        row = run_profile("rig", law, profile_config("rig", law, sampled=False))
        rows.append(replace(row, law=f"{law}, as written"))
    return "\n".join([HEADING, *(f"| {' | '.join(row.cells)} |" for row in rows)])
