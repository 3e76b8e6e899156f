"""A second on the bus as a client: the controller's status, poses, tendon states and readings of sensors."""

import time
from collections import Counter
from dataclasses import dataclass, field

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.operator import ask_status
from tendond.bus.subscription import Subscription
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.keys import TENDON_STATE, TIP_POSE, key, sensor_topic
from tendond.schemas.messages import SensorReading, Status, TendonState, TipPose
from tendond.schemas.wire import UnreadableError, decode

CONNECT_SECONDS = 0.5
LISTEN_SECONDS = 1.0
POLL_SECONDS = 0.002
QUEUE = 4096


@dataclass
class BusActivity:
    """Poses and tendon states, with the time of their arrival [ns] on the monotonic clock.

    Attributes:
        connected: true if a Zenoh session could be opened.
        status: the controller's status, received after `reply_ms`.
        error: why there is no status.
        unreadable: number of unreadable messages, by reason.
        readings: of each sensor, by name. unreadable_readings: number of those that are none, by name and reason.
    """

    connected: bool = False
    status: Status | None = None
    reply_ms: float = 0.0
    error: str = ""
    poses: list[tuple[int, TipPose]] = field(default_factory=list)
    states: list[tuple[int, TendonState]] = field(default_factory=list)
    unreadable: dict[str, int] = field(default_factory=dict)
    readings: dict[str, list[tuple[int, SensorReading]]] = field(default_factory=dict)
    unreadable_readings: Counter[str] = field(default_factory=Counter)

    def add_reading(self, sample: zenoh.Sample) -> None:
        """Add a payload of `sensor/*`, with the name in its key."""
        name = str(sample.key_expr).rpartition("/")[2]
        try:
            reading = decode(SensorReading, sample.payload.to_bytes())
        except UnreadableError as error:
            self.unreadable_readings[f"{name}: {error.detail or error.reason}"] += 1
        else:
            self.readings.setdefault(name, []).append((time.monotonic_ns(), reading))


def listen(config: RigConfig, seconds: float = LISTEN_SECONDS) -> BusActivity:
    """Query the controller, then listen; publish nothing.

    Args:
        config: the rig's configuration.
        seconds: time to listen.
    """
    activity = BusActivity()
    name = config.rig.name
    try:
        session = open_client(config.bus.endpoint, CONNECT_SECONDS)
    except (BusError, ConfigError) as error:
        activity.error = str(error)
        return activity
    with session:
        activity.connected = True
        poses = Subscription(session, key(name, TIP_POSE), TipPose, QUEUE)
        states = Subscription(session, key(name, TENDON_STATE), TendonState, QUEUE)
        sensors = session.declare_subscriber(key(name, sensor_topic("*")), zenoh.handlers.RingChannel(QUEUE))
        started = time.monotonic()
        try:
            activity.status = ask_status(session, name)
        except BusError as error:
            activity.error = str(error)
        activity.reply_ms = (time.monotonic() - started) * 1e3
        for waiting in (poses, states):  # what has arrived meanwhile says nothing about its age
            waiting.newest()
            waiting.unreadable.clear()
        while sensors.try_recv() is not None:
            pass
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            activity.poses += [(time.monotonic_ns(), pose) for pose in poses]
            activity.states += [(time.monotonic_ns(), state) for state in states]
            while time.monotonic() < until and (sample := sensors.try_recv()) is not None:
                activity.add_reading(sample)
            time.sleep(POLL_SECONDS)
        activity.unreadable = dict(poses.unreadable + states.unreadable)
    return activity
