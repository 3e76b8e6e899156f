"""Zenoh client session to the controller, which is the hub."""

import json
import os
import time
from collections.abc import Callable

import zenoh

from tendond import TendondError
from tendond.bus.file import read_bus_file
from tendond.schemas.keys import CONFIG_VARIABLE

RETRY_SECONDS = 0.2

QUEUE_SIZE = "transport/link/tx/queue/size/data"
ZENOHS_QUEUE, OUR_QUEUE = 2, 16
"""Messages that may wait to be sent. Zenoh silently drops a message whose queue is full for 1 ms: of three put in a row
(truth, tendon state, pose) the pose, if its sending thread does not run at once."""


class BusError(TendondError):
    """Error of a controller, or another process on the bus, that cannot be reached."""


class StoppedError(Exception):
    """Signal that the process was asked to stop while it waited for the controller."""


def client_config(endpoint: str) -> zenoh.Config:
    """Configure a client of one endpoint, without scouting.

    Raises:
        ConfigError: the file that ZENOH_CONFIG names cannot be used.
    """
    config = read_bus_file()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    if int(config.get_json(QUEUE_SIZE)) == ZENOHS_QUEUE:  # else it was configured
        config.insert_json5(QUEUE_SIZE, str(OUR_QUEUE))
    return config


def open_client(endpoint: str, timeout: float, stopped: Callable[[], bool] = lambda: False) -> zenoh.Session:
    """Open a client session, trying again until the controller is there.

    Args:
        endpoint: endpoint of the controller.
        timeout: time to keep trying [s].
        stopped: called between two tries; true gives up.

    Raises:
        StoppedError: `stopped` returned true.
        BusError: the controller did not appear in time.
        ConfigError: the file that ZENOH_CONFIG names cannot be used.
    """
    zenoh.init_log_from_env_or("off")
    deadline = time.monotonic() + timeout
    while True:
        try:
            return zenoh.open(client_config(endpoint))
        except zenoh.ZError as error:
            if stopped():
                raise StoppedError from error
            if time.monotonic() > deadline:
                own = os.environ.get(CONFIG_VARIABLE)
                refused = f", or the credentials in {own}" if own else ""
                raise BusError(
                    f"no controller at {endpoint}: start it with 'tendond run', or fix bus.endpoint{refused}"
                ) from error
        time.sleep(RETRY_SECONDS)
