"""A second on the bus as a client: the controller's status, and what drivers publish."""

import time
from dataclasses import dataclass, field

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask_status
from tendond.bus.subscription import Subscription
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.keys import TENDON_STATE, TIP_POSE, key
from tendond.schemas.messages import Status, TendonState, TipPose

CONNECT_SECONDS = 0.5
LISTEN_SECONDS = 1.0
POLL_SECONDS = 0.002
QUEUE = 4096


@dataclass
class Heard:
    """Poses and tendon states with the time of their arrival [ns] on the monotonic clock.

    Attributes:
        connected: to something that speaks Zenoh.
        status: the controller's answer, answered in `answer_ms`.
        error: why there is none, in words.
        unreadable: messages, by reason.
    """

    connected: bool = False
    status: Status | None = None
    answer_ms: float = 0.0
    error: str = ""
    poses: list[tuple[int, TipPose]] = field(default_factory=list)
    states: list[tuple[int, TendonState]] = field(default_factory=list)
    unreadable: dict[str, int] = field(default_factory=dict)


def listen(config: RigConfig, seconds: float = LISTEN_SECONDS) -> Heard:
    """Ask the controller, then listen; nothing is published.

    Args:
        config: of the rig.
        seconds: to listen for.
    """
    heard = Heard()
    name = config.rig.name
    try:
        session = open_client(config.bus.endpoint, CONNECT_SECONDS)
    except (BusError, ConfigError) as error:
        heard.error = str(error)
        return heard
    with session:
        heard.connected = True
        poses = Subscription(session, key(name, TIP_POSE), TipPose, QUEUE)
        states = Subscription(session, key(name, TENDON_STATE), TendonState, QUEUE)
        started = time.monotonic()
        try:
            heard.status = ask_status(session, name)
        except BusError as error:
            heard.error = str(error)
        heard.answer_ms = (time.monotonic() - started) * 1e3
        for waiting in (poses, states):  # what has arrived meanwhile says nothing about its age
            waiting.newest()
            waiting.unreadable.clear()
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            heard.poses += [(time.monotonic_ns(), pose) for pose in poses]
            heard.states += [(time.monotonic_ns(), state) for state in states]
            time.sleep(POLL_SECONDS)
        heard.unreadable = dict(poses.unreadable + states.unreadable)
    return heard
