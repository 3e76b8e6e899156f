"""The controller's end of the bus: the Zenoh hub that drivers and operators connect to."""

import json
import os
import time
from types import TracebackType
from typing import TypeVar

import zenoh

from tendond.bus.file import read_bus_file
from tendond.bus.identity import new_source
from tendond.daemon.control.sensors import sensor_reason
from tendond.daemon.errors import BusConfigError, DaemonError
from tendond.daemon.runtime.arrivals import QUEUE, Arrivals, Inbox
from tendond.daemon.runtime.requests import Requests
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import (
    ALIVE,
    CONFIG_VARIABLE,
    SIMULATOR_TRUTH,
    STATUS,
    TENDON_COMMAND,
    TENDON_STATE,
    TIP_POSE,
    key,
    sensor_topic,
)
from tendond.schemas.messages import ENCODING, Message, SensorReading, Status, TendonCommand, TendonState, TipPose
from tendond.schemas.wire import encode

M = TypeVar("M", bound=Message)


class Hub:
    """The listening session; the busy endpoint is the lock against a second controller.

    Args:
        config: configuration of the rig.
        source: identity of this controller.

    Attributes:
        requests: requests of operators.
        followed: identity of the publisher that the cycle follows, by key: of several that are heard, its messages
            are kept.

    Raises:
        DaemonError: the endpoint is taken or cannot be listened on.
    """

    def __init__(self, config: RigConfig, source: str = "") -> None:
        zenoh.init_log_from_env_or("off")
        settings = hub_settings(config)
        settings.insert_json5("mode", '"peer"')
        settings.insert_json5("listen/endpoints", json.dumps([config.bus.endpoint]))
        settings.insert_json5("scouting/multicast/enabled", "false")
        name = config.rig.name
        try:
            self._session = zenoh.open(settings)
        except zenoh.ZError as error:
            taken = "another controller is running there, or another program has the port; stop it"
            cause = taken if "in use" in str(error) else _brief(error)
            raise DaemonError(f"cannot listen on {config.bus.endpoint}: {cause}, or change bus.endpoint") from error
        self._rig = name
        self._poses = self._subscribe(TipPose, TIP_POSE)
        self._states = self._subscribe(TendonState, TENDON_STATE)
        self._readings = {
            one.name: self._subscribe(SensorReading, sensor_topic(one.name), sensor_reason(one.name, ""))
            for one in config.sensors
        }
        self._truths = self._session.declare_subscriber(key(name, SIMULATOR_TRUTH), zenoh.handlers.RingChannel(1))
        self._commands = self._session.declare_publisher(
            key(name, TENDON_COMMAND), encoding=ENCODING, priority=zenoh.Priority.REAL_TIME, express=True
        )
        self._status = self._session.declare_publisher(key(name, STATUS), encoding=ENCODING)
        self.source = source or new_source("controller")
        self.requests = Requests(self._session, name, self.source, config.loop.period)
        self.followed: dict[str, str] = {}
        self._alive = key(name, ALIVE)
        self._tokens = [self._session.liveliness().declare_token(self._alive)]
        self._controllers = self._session.liveliness().declare_subscriber(
            f"{self._alive}/*", zenoh.handlers.RingChannel(QUEUE), history=True
        )
        self._others: dict[str, None] = {}  # identities of other controllers
        self.last_command: TendonCommand | None = None

    def __enter__(self) -> "Hub":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._session.close()

    def _subscribe(self, kind: type[M], topic: str, prefix: str = "") -> Inbox[M]:
        ring: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(QUEUE)
        return Inbox(kind, topic, self._session.declare_subscriber(key(self._rig, topic), ring), prefix)

    def _newest(self, inbox: Inbox[M], newest: M | None, arrivals: Arrivals, *, repeating: bool) -> M | None:
        return inbox.newest(newest, arrivals, self.followed.get(inbox.topic), repeating=repeating)

    def receive(self, arrivals: Arrivals | None = None, *, repeating: bool = False) -> Arrivals:
        """Add all that has come in since the last call to `arrivals`; never block.

        Args:
            arrivals: arrivals of this cycle so far.
            repeating: the sender says the same again until it gets a reply; that is no message out of order.
        """
        arrivals = arrivals or Arrivals()
        before = arrivals.pose
        arrivals.pose = self._newest(self._poses, before, arrivals, repeating=repeating)
        if arrivals.pose is not None and arrivals.pose is not before and not repeating:
            arrivals.pose_lag = (time.monotonic_ns() - arrivals.pose.stamp_ns) * 1e-9
        arrivals.tendon_state = self._newest(self._states, arrivals.tendon_state, arrivals, repeating=repeating)
        for name, inbox in self._readings.items():
            last = arrivals.readings.get(name)
            reading = self._newest(inbox, last, arrivals, repeating=repeating)
            if reading is None or reading is last:
                continue
            arrivals.readings[name] = reading
            if not repeating:
                arrivals.reading_lags[name] = (time.monotonic_ns() - reading.stamp_ns) * 1e-9
        if others := self.other_controllers():
            arrivals.others[ALIVE] = others[-1]
        arrivals.truth = self._truths.try_recv() or arrivals.truth
        return arrivals

    def claim(self) -> None:
        """Be the rig's controller, as which others know this one from now on.

        Raises:
            DaemonError: another one is, on another endpoint of the same bus.
        """
        if others := self.other_controllers():
            raise DaemonError(
                f"'{self._alive.partition('/')[0]}' has a controller already, '{others[-1]}', on another endpoint of "
                "this bus: stop it, or give one of the rigs another name ([rig] name)"
            )
        self._tokens.append(self._session.liveliness().declare_token(f"{self._alive}/{self.source}"))

    def other_controllers(self) -> list[str]:
        """Identities of other controllers of this rig that are on the bus now."""
        for _ in range(QUEUE):
            if (sample := self._controllers.try_recv()) is None:
                break
            name = str(sample.key_expr).rsplit("/", 1)[-1]
            if sample.kind == zenoh.SampleKind.PUT and name != self.source:
                self._others[name] = None
            else:
                self._others.pop(name, None)
        return list(self._others)

    def publish_command(self, command: TendonCommand) -> None:
        """Publish a command to the servos or the simulator."""
        command = command.named(self.source)
        self.last_command = command
        self._commands.put(encode(command))

    def repeat_command(self) -> None:
        """The last command again, if there was one."""
        if self.last_command is not None:
            self._commands.put(encode(self.last_command))

    def publish_last(self, command: TendonCommand) -> None:
        """A command that must not be lost: waits for the network, which the loop never does."""
        command = command.named(self.source)
        self._session.put(
            self._commands.key_expr,
            encode(command),
            encoding=ENCODING,
            congestion_control=zenoh.CongestionControl.BLOCK,
        )

    def publish_status(self, status: Status) -> None:
        """Publish the status."""
        self._status.put(encode(status.named(self.source)))


def hub_settings(config: RigConfig) -> zenoh.Config:
    """Return the settings of the file that ZENOH_CONFIG names: users, certificates, access; defaults without it.

    Raises:
        ConfigError: the file cannot be used. BusConfigError: the bus would be open to a network.
    """
    path = os.environ.get(CONFIG_VARIABLE)
    settings = read_bus_file()
    guarded = json.loads(settings.get_json("access_control"))["enabled"]
    connects = bool(json.loads(settings.get_json("connect/endpoints")))
    if not (guarded or config.bus.unguarded or (config.bus.is_loopback and not connects)):
        bus = f"what {path} connects to" if connects else f"bus.endpoint = {config.bus.endpoint}"
        raise BusConfigError(
            f"{bus} is open to the network and has no access list: name a Zenoh configuration with one in "
            "ZENOH_CONFIG (examples in deploy/bus), or set bus.unguarded = true"
        )
    return settings


def _brief(error: zenoh.ZError) -> str:
    """Zenoh's reason without its places in the source."""
    return str(error).split(" at ", 1)[0].strip()
