"""Commands without the cycle: the release after a crash, and the slack command that leaves the process last."""

import time

import numpy as np

from tendond.daemon.runtime.bus import Hub
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import TendonCommand

RELEASE_SECONDS = 4.0
"""Longest release after SIGTERM, before the loop ends all the same [s]."""


def release_at_once(config: RigConfig, hub: Hub) -> None:
    """Release the tendons along a ramp from what was commanded last.

    The ramp is `limits.release_rate`, or as steep as it must be to end within `RELEASE_SECONDS`.
    """
    last = hub.last_command
    if last is None or not last.armed:
        return
    tension, displacement = np.array(last.tension), np.array(last.displacement)
    rate = max(config.limits.release_rate, float(np.max(tension)) / RELEASE_SECONDS)
    while np.any(tension > 0.0):
        less = np.maximum(tension - rate * config.loop.period, 0.0)
        left = float(np.sum(less) / np.sum(tension))
        displacement = np.where(displacement > 0.0, left * displacement, displacement)
        tension = less
        hub.publish_command(
            TendonCommand(
                seq=next_seq(hub),
                stamp_ns=time.monotonic_ns(),
                pose_seq=None,
                displacement=tuple(displacement.tolist()),
                tension=tuple(tension.tolist()),
                armed=True,
            )
        )
        time.sleep(config.loop.period)


def next_seq(hub: Hub) -> int:
    """Return the count of the next command: drivers drop one whose count does not increase."""
    return 0 if hub.last_command is None else hub.last_command.seq + 1


def slack_command(tendon_count: int, seq: int) -> TendonCommand:
    """Return the command that is safe whatever has happened: slack and disarmed."""
    zeros = (0.0,) * tendon_count
    return TendonCommand(
        seq=seq, stamp_ns=time.monotonic_ns(), pose_seq=None, displacement=zeros, tension=zeros, armed=False
    )
