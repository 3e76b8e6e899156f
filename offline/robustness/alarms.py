"""Check of a fault for a true alarm: the same run once more, with the watches of the loop's behaviour off."""

import numpy as np

from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.errors import ConvergenceError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

LATER = 6.0
"""Time from the fault on in which a loop that the fault need not have ended comes to rest [s]."""

LAST = 1.25
"""Last part of it, in which the tip is looked at [s]: half a period of the slowest swing that the faults look for."""

REST = 0.25
"""Part of what the watches call a swing, below which a loop is at rest: one that rings at 16 Hz with half of it after
six seconds has a damping ratio of 0.001."""

OFF = 1e6
"""A threshold that is never reached."""

WATCHES = ("swing", "tension_swing", "tracking_error", "jump", "mismatch")
"""Keys of [faults]; `limits.limit_time` is switched off with them."""

TRUE, FALSE = "true", "false"


def unwatched(config: RigConfig) -> RigConfig:
    """Return the same rig without those faults: it may swing, stay at a limit, or stay off its reference."""
    return config.model_copy(
        update={
            "faults": config.faults.model_copy(update=dict.fromkeys(WATCHES, OFF)),
            "limits": config.limits.model_copy(update={"limit_time": OFF}),
        }
    )


def judge_alarm(config: RigConfig, arm: int, fault: int) -> str:
    """Return `FALSE` if the loop would have come to rest at its reference without the fault, `TRUE` if not.

    At rest: in the last `LAST` seconds the true tip swings by less than `REST` times `faults.swing` of the length,
    and ends within `faults.tracking_error` of it from the reference; the commanded tension swings by less than `REST`
    times `faults.tension_swing` of its maximum. Pushes that come after the fault are left out.

    Args:
        config: configuration of the run that ended in a fault.
        arm: cycle in which it is armed. fault: cycle in which it ended.
    """
    period, length, faults = config.loop.period, config.rod.length, config.faults
    simulator = config.simulator
    pushes = tuple(push for push in simulator.impacts if push.time <= fault * period)
    config = config.model_copy(update={"simulator": simulator.model_copy(update={"impacts": pushes})})
    tips, commands, apart = [], [], 0.0
    try:
        for watched in watched_loop(unwatched(config), fault + round(LATER / period), {arm: ControlAction.ARM}):
            if watched.record.mode is Mode.FAULT:
                return TRUE
            tips.append(watched.truth.position)
            commands.append(watched.record.command.tension)
            apart = float(np.linalg.norm(np.subtract(watched.truth.position, watched.record.reference.position)))
    except ConvergenceError:
        return TRUE
    last = round(LAST / period)
    swing = float(np.max(np.ptp(np.array(tips[-last:]), axis=0)))
    chatter = float(np.max(np.ptp(np.array(commands[-last:]), axis=0)))
    rests = swing < REST * faults.swing * length and chatter < REST * faults.tension_swing * config.limits.tension_max
    return FALSE if rests and apart < faults.tracking_error * length else TRUE
