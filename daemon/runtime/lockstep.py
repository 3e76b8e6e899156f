"""Pacing of the cycles by the next pose, in lockstep with a simulator."""

import time
from collections.abc import Callable

from tendond.bus.subscription import LOCKSTEP_POLL_SECONDS
from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.bus import Hub
from tendond.daemon.runtime.pacing import Wake
from tendond.schemas.messages import SensorReading

LOCKSTEP_PATIENCE_SECONDS = 5.0
"""Longest step of a simulator before it counts as gone [s]."""


class Lockstep:
    """One cycle for each pose: for simulation, faster than real time and repeatable.

    A simulator that has not had its reply publishes the same pose again, and gets the same command again. When no pose
    comes for a while, cycles come all the same: faults, requests and the release need them.

    Args:
        hub: hub of the controller.
        period: period of the cycle [s].
        stopped: true when the process is to end; asked while no pose has come yet.
    """

    def __init__(self, hub: Hub, period: float, stopped: Callable[[], bool]) -> None:
        self._hub = hub
        self._period = period
        self._stopped = stopped
        self._seq: int | None = None
        self._readings: dict[str, SensorReading] = {}
        self._patience = LOCKSTEP_PATIENCE_SECONDS

    def wait(self) -> Wake | None:
        """Wait for a pose with a new sequence number."""
        arrivals = Arrivals()
        started = time.monotonic()
        while self._seq is not None or not self._stopped():
            self._hub.receive(arrivals, repeating=True)
            if arrivals.pose is not None:
                self._patience = LOCKSTEP_PATIENCE_SECONDS
                if arrivals.pose.seq != self._seq:
                    self._seq = arrivals.pose.seq
                    self._drop_repeated(arrivals)
                    return Wake(time.monotonic(), arrivals, 0.0, 0)
                arrivals.pose = None
                self._hub.repeat_command()
            elif self._seq is not None and time.monotonic() - started > self._patience:
                self._patience = self._period
                return Wake(time.monotonic(), arrivals, 0.0, 0)
            time.sleep(LOCKSTEP_POLL_SECONDS)
        return None

    def _drop_repeated(self, arrivals: Arrivals) -> None:
        """Leave out readings that an earlier cycle had, which came again with its pose."""
        arrivals.readings = {
            name: reading for name, reading in arrivals.readings.items() if reading != self._readings.get(name)
        }
        self._readings.update(arrivals.readings)
