"""One run of `daemon.control.cycle` and the MuJoCo plant under a weight on the tip, and its measures.

A rigid body that the controller knows nothing of hangs on the tip from the start; the plant's E is not the model's; the
poses are delayed, and the delay is configured or not.
"""

import math
from dataclasses import dataclass

import numpy as np

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.drivers.mujoco.robot import DivergedError
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.plants.paper_robot import Robot
from tests.plants.rig import MujocoRig, RigSettings

ARM_AT = 1.0
"""Time of arming [s]: idle before, so that the observer estimates the weight."""

PATIENCE = 15.0
"""Time from arming to tracking after which a run is given up [s]."""

TRACKING = 12.0
"""Time of tracking in a run [s]."""

WINDOW = 2.0
"""Time at the run's end over which ripple and error are taken [s]."""

RIPPLE_MAX = 0.2e-3
"""Allowed ripple of any coordinate of the true tip, peak to peak [m]."""

BAND = 0.05
"""Fraction of the target within which the tip has settled."""


@dataclass(frozen=True)
class Case:
    """Conditions of a run.

    Attributes:
        law: law of the controller. rate: rate of the loop [Hz].
        mass: mass on the tip [g]. stiffness: E of the plant as a multiple of the model's.
        known_delay, unknown_delay: delay of the poses in cycles, configured for the observer and not.
        drive: 'tension' or 'displacement'. damping: Bbt of the plant as a multiple of the model's.
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
    """Outcome of a run.

    Attributes:
        mode: mode at the end. reason: its reason.
        settling: time of tracking after which x stays within 5 % of the target [s]; none if it does not.
        ripple: peak to peak of the worst coordinate of the true tip in the last 2 s [mm].
        error: mean of |x - target| then [mm].
        tension: largest command [N].
        passed: settled, and with little ripple.
    """

    mode: str
    reason: str
    settling: float | None
    ripple: float | None
    error: float | None
    tension: float
    passed: bool


def configuration(case: Case) -> RigConfig:
    """Return the controller's configuration: the default, but for law, rate and the known delay."""
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
        RigSettings(period, case.known_delay + case.unknown_delay, case.noise / 1e3, case.drive == "displacement"),
    )
    setup = CycleSetup.from_config(config)
    state = initial_state(setup)
    arm, cycles = round(ARM_AT / period), math.ceil(tracking / period)
    tips: list[np.ndarray] = []
    tension_max, target = 0.0, setup.selection.reference.target[0]
    reason = "it never tracked"
    for tick in range(arm + round(PATIENCE / period) + cycles):
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
            tension_max = max(tension_max, *command.tension)
        if tick == arm and not record.accepted:
            reason = record.reply
            break
        if record.mode is Mode.FAULT or len(tips) >= cycles:
            reason = record.reason
            break
        try:
            rig.advance(np.array(command.tension), np.array(command.displacement), command.armed)
        except DivergedError as error:
            reason = str(error)
            break
    if len(tips) < cycles:
        return Outcome(str(state.mode), reason, None, None, None, tension_max, False)
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
        tension=tension_max,
        passed=settling is not None and ripple <= RIPPLE_MAX,
    )
