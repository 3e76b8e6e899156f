"""A second on the bus as a client: the controller's status, and what drivers publish."""

import time
from dataclasses import dataclass, field
from typing import TypeVar

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.keys import TENDON_STATE, TIP_POSE, key
from tendond.schemas.messages import ControlAction, Message, Status, TendonState, TipPose
from tendond.schemas.wire import UnreadableError, decode

CONNECT_SECONDS = 0.5
LISTEN_SECONDS = 1.0
POLL_SECONDS = 0.002

M = TypeVar("M", bound=Message)


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
        poses = session.declare_subscriber(key(name, TIP_POSE), zenoh.handlers.FifoChannel(4096))
        states = session.declare_subscriber(key(name, TENDON_STATE), zenoh.handlers.FifoChannel(4096))
        started = time.monotonic()
        try:
            heard.status = ask(session, name, ControlAction.STATUS).status
        except BusError as error:
            heard.error = str(error)
        heard.answer_ms = (time.monotonic() - started) * 1e3
        _drain(poses, TipPose, Heard())  # what has waited meanwhile says nothing of its age
        _drain(states, TendonState, Heard())
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            heard.poses += _drain(poses, TipPose, heard)
            heard.states += _drain(states, TendonState, heard)
            time.sleep(POLL_SECONDS)
    return heard


def _drain(
    subscriber: zenoh.Subscriber[zenoh.handlers.Handler[zenoh.Sample]], kind: type[M], heard: Heard
) -> list[tuple[int, M]]:
    messages = []
    while (sample := subscriber.try_recv()) is not None:
        try:
            messages.append((time.monotonic_ns(), decode(kind, sample.payload.to_bytes())))
        except UnreadableError as error:
            heard.unreadable[error.reason] = heard.unreadable.get(error.reason, 0) + 1
    return messages
