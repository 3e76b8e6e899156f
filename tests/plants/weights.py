"""Run the closed loop of `daemon.control.cycle` and the MuJoCo plant over a grid of weights on the tip.

A rigid body that the controller knows nothing of hangs on the tip from the start; the plant's E is not the model's; the
poses are delayed, and the delay is configured or not. `python -m tests.plants.weights` prints a row for each run, and
exits with 1 where one falls short: not settled, or a ripple above 0.2 mm.
"""

import argparse
import itertools
import json
import math
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, fields

import numpy as np

from tendond.daemon.control.cycle import step
from tendond.daemon.control.state import CycleSetup, initial_state
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.plants.mujoco_robot import DivergedError, Robot
from tests.plants.rig import MujocoRig, Rig

LAWS = ("backstepping", "sliding_mode", "sensitivity")
RATES = (100, 250)
MASSES = (0.0, 20.0, 35.0, 50.0, 100.0)
STIFFNESSES = (0.85, 1.0, 1.15)
DELAYS = ((0, 0), (1, 0), (2, 0), (3, 0), (0, 1))
"""(known_delay, unknown_delay), in cycles."""

ARM_AT = 1.0
"""[s] Idle before, so that the observer sees the weight."""

PATIENCE = 15.0
"""[s] From arming to tracking; more is a run that does not start."""

TRACKING = 12.0
"""[s] Of tracking in a run."""

WINDOW = 2.0
"""[s] At the run's end, over which ripple and error are taken."""

RIPPLE_MAX = 0.2e-3
"""[m] Peak to peak, of any coordinate of the true tip."""

BAND = 0.05
"""Fraction of the target within which the tip has settled."""


@dataclass(frozen=True)
class Case:
    """A run.

    Attributes:
        law: of the controller. rate: of the loop [Hz].
        mass: on the tip [g]. stiffness: E of the plant against the model's.
        known_delay, unknown_delay: of the poses in cycles, configured for the observer and not.
        drive: 'tension' or 'displacement'. damping: Bbt of the plant against the model's.
        noise: standard deviation of the poses [mm].
    """

    law: str = "backstepping"
    rate: int = 100
    mass: float = 0.0
    stiffness: float = 1.0
    known_delay: int = 0
    unknown_delay: int = 0
    drive: str = "tension"
    damping: float = 1.0
    noise: float = 0.1


@dataclass(frozen=True)
class Outcome:
    """Outcome of a trial.

    Attributes:
        mode: at the end. reason: of it.
        settling: time of tracking after which x stays within 5 % of the target [s]; none if it does not.
        ripple: peak to peak of the worst coordinate of the true tip in the last 2 s [mm].
        error: mean of |x - target| then [mm].
        tension: largest commanded [N].
        passed: settled, and with little ripple.
    """

    mode: str
    reason: str
    settling: float | None
    ripple: float | None
    error: float | None
    tension: float
    passed: bool


SHORT = (
    Case(mass=0.0),
    Case(mass=35.0),
    Case(mass=50.0),
    Case(mass=100.0),
    Case(mass=35.0, stiffness=0.85, known_delay=2),
    Case(mass=50.0, stiffness=0.85, unknown_delay=1),
    Case(mass=100.0, stiffness=0.85, known_delay=3),
    Case(mass=35.0, stiffness=1.15, unknown_delay=1, law="sliding_mode"),
    Case(mass=50.0, rate=250, stiffness=0.85, known_delay=3, law="sliding_mode"),
    Case(mass=20.0, law="sensitivity"),
    Case(mass=35.0, stiffness=0.85, unknown_delay=1, law="sensitivity"),
    Case(mass=100.0, rate=250, stiffness=0.85, known_delay=3, law="sensitivity"),
)
"""The report's own, and corners of the grid."""


def configuration(case: Case) -> RigConfig:
    """The controller's: the default, but for law, rate and the known delay."""
    values: dict[str, object] = {
        "loop": {"period": 1.0 / case.rate},
        "control": {"law": case.law},
        "observer": {"delay": case.known_delay / case.rate},
    }
    if case.drive == "displacement":
        values["rod"] = {"tendon_stiffness": Robot().stiffness}
        values["limits"] = {"slack": 0.002}
    return check_config(values, str(case))


def run(case: Case, tracking: float = TRACKING) -> Outcome:
    """Run a case and measure it.

    Args:
        case: to run.
        tracking: time of tracking [s], longer than `WINDOW`.
    """
    config = configuration(case)
    period = config.loop.period
    model = Robot()
    robot = Robot(
        youngs_modulus=case.stiffness * model.youngs_modulus,
        damping=case.damping * model.damping,
        tip_mass=case.mass / 1e3,
        step=1e-3 if case.drive == "tension" else 5e-4,
    )
    rig = MujocoRig(
        robot,
        Rig(period, case.known_delay + case.unknown_delay, case.noise / 1e3, case.drive == "displacement"),
    )
    setup = CycleSetup.from_config(config)
    state = initial_state(setup)
    arm, wanted = round(ARM_AT / period), math.ceil(tracking / period)
    tips: list[np.ndarray] = []
    most, target = 0.0, setup.selection.reference.target[0]
    reason = "it never tracked"
    for tick in range(arm + round(PATIENCE / period) + wanted):
        position, quaternion = (tuple(part.tolist()) for part in rig.pose())
        stamp = round(tick * period * 1e9)
        inputs = CycleInputs(
            pose=TipPose(seq=tick, stamp_ns=stamp, position=position, orientation=quaternion),
            tendon_state=TendonState(
                seq=tick,
                stamp_ns=stamp,
                displacement=tuple(rig.plant.displacement.tolist()),
                tension=tuple(rig.plant.tension.tolist()),
            ),
            request=ControlAction.ARM if tick == arm else None,
        )
        state, command, record = step(setup, state, inputs)
        if record.mode is Mode.TRACKING:
            tips.append(rig.plant.position)
            target = record.reference.target[0]
            most = max(most, *command.tension)
        if tick == arm and not record.accepted:
            reason = record.reply
            break
        if record.mode is Mode.FAULT or len(tips) >= wanted:
            reason = record.reason
            break
        try:
            rig.advance(np.array(command.tension), np.array(command.displacement), command.armed)
        except DivergedError as error:
            reason = str(error)
            break
    if len(tips) < wanted:
        return Outcome(str(state.mode), reason, None, None, None, most, False)
    x = np.array(tips)
    last = x[-round(WINDOW / period) :]
    outside = np.flatnonzero(np.abs(x[:, 0] - target) > BAND * abs(target))
    settled = 0 if not len(outside) else int(outside[-1]) + 1
    settling = settled * period if settled <= len(x) - len(last) else None
    ripple = float((last.max(axis=0) - last.min(axis=0)).max())
    return Outcome(
        mode=str(state.mode),
        reason="",
        settling=settling,
        ripple=ripple * 1e3,
        error=float(np.abs(last[:, 0] - target).mean()) * 1e3,
        tension=most,
        passed=settling is not None and ripple <= RIPPLE_MAX,
    )


def grid() -> Iterator[Case]:
    """All of them."""
    for rate, law, mass, stiffness, (known_delay, unknown_delay) in itertools.product(
        RATES, LAWS, MASSES, STIFFNESSES, DELAYS
    ):
        yield Case(
            law=law, rate=rate, mass=mass, stiffness=stiffness, known_delay=known_delay, unknown_delay=unknown_delay
        )


HEADING = (
    f"{'law':12} {'Hz':>3} {'drive':>7} {'g':>4} {'E':>5} {'Bbt':>4} {'known':>5} {'unknown':>7}  {'settled s':>9} "
    f"{'ripple mm':>9} {'error mm':>8} {'most N':>6}"
)


def line(case: Case, outcome: Outcome) -> str:
    """A row of the table."""

    def number(value: float | None, form: str) -> str:
        return "-" if value is None else format(value, form)

    return (
        f"{case.law:12} {case.rate:3d} {case.drive[:7]:>7} {case.mass:4.0f} {case.stiffness:5.2f} {case.damping:4.1f} "
        f"{case.known_delay:5d} {case.unknown_delay:7d}  {number(outcome.settling, '.2f'):>9} "
        f"{number(outcome.ripple, '.3f'):>9} {number(outcome.error, '.2f'):>8} {outcome.tension:6.1f}  "
        f"{'ok' if outcome.passed else 'FALLS SHORT ' + outcome.reason}".rstrip()
    )


def summary(outcomes: Sequence[tuple[Case, Outcome]]) -> Iterator[str]:
    """A table of what became of the runs of each law and rate, as Markdown."""
    yield "| law | loop [Hz] | runs | settled, ripple <= 0.2 mm | largest ripple [mm] | slowest [s] |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for law, rate in dict.fromkeys((case.law, case.rate) for case, _ in outcomes):
        some = [outcome for case, outcome in outcomes if (case.law, case.rate) == (law, rate)]
        ripples = [outcome.ripple for outcome in some if outcome.ripple is not None]
        times = [outcome.settling for outcome in some if outcome.settling is not None]
        yield (
            f"| {law} | {rate} | {len(some)} | {sum(outcome.passed for outcome in some)} "
            f"| {max(ripples, default=math.nan):.3f} | {max(times, default=math.nan):.2f} |"
        )


def main(arguments: list[str] | None = None) -> int:
    """Run the grid, or the part of it that the options name; the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.plants.weights", description=__doc__)
    parser.add_argument("--short", action="store_true", help=f"run {len(SHORT)} chosen cases only")
    parser.add_argument("--json", action="store_true", help="print one JSON object a line")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="processes (default: all processors)")
    parser.add_argument("--tracking", type=float, default=TRACKING, help="time of tracking in a run [s] (default: 12)")
    for field in fields(Case):
        kind = type(field.default)
        parser.add_argument(
            f"--{field.name.replace('_', '-')}", type=kind, nargs="+", help="only these, or for all if none has them"
        )
    options = parser.parse_args(arguments)
    if options.tracking <= WINDOW:
        parser.error(f"--tracking {options.tracking:g}: longer than {WINDOW:g} s, over which the ripple is taken")
    cases = list(SHORT if options.short else grid())
    for field in fields(Case):
        only = getattr(options, field.name)
        if only is not None:
            kept = [case for case in cases if getattr(case, field.name) in only]
            cases = kept or list(
                dict.fromkeys(Case(**{**asdict(case), field.name: value}) for case in cases for value in only)
            )
    if not options.json:
        print(HEADING, flush=True)
    outcomes: list[tuple[Case, Outcome]] = []
    with ProcessPoolExecutor(options.jobs) as pool:
        for case, outcome in zip(cases, pool.map(run, cases, itertools.repeat(options.tracking)), strict=True):
            outcomes.append((case, outcome))
            text = json.dumps({**asdict(case), **asdict(outcome)}) if options.json else line(case, outcome)
            print(text, flush=True)
    if not options.json:
        print("", *summary(outcomes), sep="\n")
    return 0 if all(outcome.passed for _, outcome in outcomes) else 1


if __name__ == "__main__":
    sys.exit(main())
