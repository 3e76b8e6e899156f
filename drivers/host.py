"""Surroundings of a driver's process: the request to stop, lines for people, the service manager, the bus."""

from collections.abc import Callable
from dataclasses import dataclass, field

import zenoh

from tendond.bus.client import open_client
from tendond.bus.systemd import Supervisor
from tendond.schemas.config.rig import RigConfig

CONNECT_SECONDS = 120.0
"""Time for which a driver waits for its controller [s]."""


@dataclass(frozen=True)
class Host:
    """Surroundings of a driver.

    Attributes:
        stopped: true when the process is to end.
        say: a line for people.
        supervisor: notified when the driver is ready, of each cycle done in time, and of the end.
    """

    stopped: Callable[[], bool]
    say: Callable[[str], None]
    supervisor: Supervisor = field(default_factory=lambda: Supervisor({}))


def await_controller(config: RigConfig, stopped: Callable[[], bool]) -> zenoh.Session:
    """Open a client session of the rig's controller, once it is there.

    Raises:
        StoppedError: the process is to end.
        BusError: there is no controller in time.
    """
    return open_client(config.bus.endpoint, CONNECT_SECONDS, stopped)
