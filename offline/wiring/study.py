"""Run each mistake, and many right rigs, in lockstep: refused or faulted in time, and never without cause."""

import math
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache

import numpy as np

from tendond.daemon.control.commissioning.rotations import turn_by
from tendond.daemon.control.laws import LAWS
from tendond.drivers.simulator.lockstep import Wires, watched_loop
from tendond.model.errors import ConvergenceError
from tendond.offline.wiring.mistakes import Mistake, all_mistakes, with_poses
from tendond.schemas.config.presets import RIG
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

CHAINS = {"ideal": "", "wired": RIG}
"""The plant: tensions as commanded; or the real rig's servos, elastic tendons, and poses with noise and delay."""

ARM_SECONDS, TRACK_SECONDS, RELEASE_SECONDS = 0.8, 6.0, 0.5
"""Time until it is armed; maximum time of tracking; time that is still watched after the release [s]."""

MOVED, PULLED = 0.1, 0.2
"""Limits for a wrong rig: fraction of the length beyond the probe, fraction of tension_max."""

PROBED = 0.03
"""Travel of the tip during the probe, as a fraction of the rod's length."""

RIGHT = "right rigs"
"""Group of the rigs that nothing is wrong with."""

EVERY_LAW = ("tendons in another order and reversed",)
"""Groups that are run with one law only: 345 of them, and none that gets beyond the probe, which knows no law."""


@dataclass(frozen=True)
class WiringOutcome:
    """Outcome of a run.

    Attributes:
        group, name, law, chain: the run.
        noticed: refused, or in fault. by: the reply to the request, or the reason of the fault.
        seconds: time from the request to the fault; 0 where it was refused.
        moved: farthest that the true tip went from where it rested, as a part of the rod's length [-].
        pulled: largest true tension, as a part of tension_max [-].
        probed: time from the request to the end of a probe that was passed [s]; none where there was no such end.
    """

    group: str
    name: str
    law: str
    chain: str
    noticed: bool
    by: str
    seconds: float
    moved: float
    pulled: float
    probed: float | None = None

    @property
    def in_time(self) -> bool:
        """True if a wrong rig was noticed before it moved far or was pulled hard."""
        return self.noticed and self.moved <= MOVED + PROBED and self.pulled <= PULLED


@dataclass(frozen=True)
class Job:
    """A run: a mistake's index in `all_mistakes`, or a right rig's number."""

    chain: str
    law: str
    mistake: int | None
    setup: int = 0


def jobs(laws: Sequence[str], setups: int, groups: Sequence[str] | None = None) -> Iterator[Job]:
    """Everything that the study runs; with `groups`, only those rows."""
    for chain in CHAINS:
        mistakes = mistakes_of(chain)
        for index, mistake in enumerate(mistakes):
            if groups is None or mistake.group in groups:
                for law in laws[:1] if mistake.group in EVERY_LAW else laws:
                    yield Job(chain, law, index)
    for number in range(setups):
        yield Job(tuple(CHAINS)[number % 2], laws[number // 2 % len(laws)], None, number)


def run_study(work: Sequence[Job], processes: int | None = None) -> Iterator[WiringOutcome]:
    """Run jobs in a pool of processes, in their order."""
    count = processes or os.cpu_count() or 1
    if count == 1:
        yield from map(run_job, work)
        return
    with ProcessPoolExecutor(count) as pool:
        yield from pool.map(run_job, work, chunksize=8)


def run_job(job: Job, tracking: float = TRACK_SECONDS) -> WiringOutcome:
    """Run one, with `tracking` seconds of tracking at most."""
    if job.mistake is None:
        config, wires, text = right_rig(job)
        return run(config, wires, RIGHT, text, job, tracking)
    mistake = mistakes_of(job.chain)[job.mistake]
    return run(_config(job.chain, job.law), mistake.wires(), mistake.group, mistake.name, job, tracking)


def run(config: RigConfig, wires: Wires, group: str, name: str, job: Job, tracking: float) -> WiringOutcome:
    """Arm a rig on its wires, and watch it to its fault or for some seconds."""
    period = config.loop.period
    arm, count = round(ARM_SECONDS / period), round((ARM_SECONDS + 12.0 + TRACK_SECONDS) / period)
    start, moved, pulled, left = np.zeros(3), 0.0, 0.0, -1
    by, noticed, seconds, tracked, probed = "", False, 0.0, 0, None
    try:
        for watched in watched_loop(config, count, {arm: ControlAction.ARM}, probe=True, wires=wires):
            record, truth = watched.record, watched.truth
            if record.tick == arm:
                start = np.array(truth.position)
                by = record.reply
                if not record.accepted:
                    return WiringOutcome(group, name, job.law, job.chain, True, by, 0.0, 0.0, 0.0)
            if record.tick < arm:
                continue
            moved = max(moved, float(np.linalg.norm(np.array(truth.position) - start)))
            pulled = max(pulled, max(truth.tension))
            tracked += record.mode is Mode.TRACKING
            if probed is None and record.mode is Mode.PRETENSION:
                probed = (record.tick - arm) * period
            if record.mode is Mode.FAULT and not noticed:
                noticed, by, seconds = True, record.reason, (record.tick - arm) * period
            if noticed and left < 0 and not record.command.armed:
                left = round(RELEASE_SECONDS / period)
            left -= left > 0
            if left == 0 or tracked >= tracking / period:
                break
    except ConvergenceError as error:
        noticed, by = False, f"the plant has no solution: {error}"
    limits = config.limits.tension_max
    return WiringOutcome(
        group, name, job.law, job.chain, noticed, by, seconds, moved / config.rod.length, pulled / limits,
        probed,
    )  # fmt: skip


@cache
def mistakes_of(chain: str) -> list[Mistake]:
    """List every mistake of a chain."""
    return all_mistakes(_config(chain, "backstepping"))


@cache
def _config(chain: str, law: str) -> RigConfig:
    """Return the configuration of a chain with a law; its poses have realistic noise."""
    config = parse_config(CHAINS[chain], chain)
    control = config.control.model_copy(update={"law": law})
    mocap = config.simulator.mocap.model_copy(update={"noise": 1e-4, "rotation_noise": 2e-3})
    return config.model_copy(
        update={"control": control, "simulator": config.simulator.model_copy(update={"mocap": mocap})}
    )


def right_rig(job: Job) -> tuple[RigConfig, Wires, str]:
    """Draw a correct rig: stiffness, weight, noise, delay, friction and base within tolerance."""
    random = np.random.default_rng([11, job.setup])
    config, section = _config(job.chain, job.law), _config(job.chain, job.law).simulator
    stiffness, weight, noise = random.uniform(0.8, 1.2), random.uniform(0.0, 0.05), random.uniform(0.0, 3e-4)
    late, friction = random.integers(0, 2) * config.loop.period, random.uniform(0.0, 0.1)
    tilt = math.radians(2.0) * random.uniform() * _direction(random)
    offset = 0.002 * random.uniform() * _direction(random)
    turn = turn_by(tilt)
    gx, gy, gz = (turn.T @ np.array(config.rod.base_gravity)).tolist()
    rod = section.rod.model_copy(
        update={"youngs_modulus": stiffness * section.rod.youngs_modulus, "gravity": (gx, gy, gz), "base": None}
    )
    simulator = section.model_copy(
        update={
            "rod": rod,
            "seed": job.setup,
            "weight": section.weight.model_copy(update={"mass": weight}),
            "mocap": section.mocap.model_copy(update={"noise": noise, "latency": section.mocap.latency + late}),
            "servo": section.servo.model_copy(update={"friction": friction if job.chain == "wired" else 0.0}),
        }
    )
    text = (
        f"E x {stiffness:.2f}, {weight * 1e3:.0f} g, noise {noise * 1e3:.2f} mm, {late * 1e3:.0f} ms late, friction "
        f"{friction:.2f}, base {math.degrees(float(np.linalg.norm(tilt))):.1f} degrees and "
        f"{float(np.linalg.norm(offset)) * 1e3:.1f} mm off"
    )
    wires = with_poses(lambda p, r: (turn @ p + offset, turn @ r))()
    return config.model_copy(update={"simulator": simulator}), wires, text


def _direction(random: np.random.Generator) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Draw a uniformly distributed direction, shape (3,)."""
    vector = random.standard_normal(3)
    return np.asarray(vector / np.linalg.norm(vector))


def laws() -> tuple[str, ...]:
    """Return the names of all laws."""
    return tuple(LAWS)
