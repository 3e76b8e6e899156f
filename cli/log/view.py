"""`tendond log view`: a Foxglove WebSocket server of its own process, fed from Zenoh or from a log."""

import time
from collections import deque
from pathlib import Path
from typing import Any

from tendond.bus.client import open_client
from tendond.bus.subscription import Subscription
from tendond.cli.common import load_config, say
from tendond.daemon.control.state import rod_from_section
from tendond.daemon.errors import UsageError
from tendond.daemon.recording import foxglove
from tendond.daemon.recording.channels import (
    CHANNELS,
    CYCLE,
    ROD_SHAPE,
    STATUS,
    TIP_MEASURED,
    TIP_MODEL,
    TRANSFORMS,
    TRUTH,
    Channel,
)
from tendond.model import ModelError
from tendond.model.numerics.rotation import quaternion
from tendond.offline.logs.log import Run, no_cycles, open_run
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import SIMULATOR_TRUTH, TENDON_COMMAND, TENDON_STATE, TIP_POSE, key
from tendond.schemas.keys import STATUS as STATUS_KEY
from tendond.schemas.messages import Message, SimulatorTruth, Status, TendonCommand, TendonState, TipPose
from tendond.schemas.wire import encode

COMMAND = Channel("tendon/command", TendonCommand)
TENDONS = Channel("tendon/state", TendonState)
LIVE = (TIP_MEASURED, TIP_MODEL, ROD_SHAPE, TRANSFORMS, STATUS, TRUTH, COMMAND, TENDONS)
KINDS: dict[str, type[Message]] = {
    TIP_POSE: TipPose,
    TENDON_COMMAND: TendonCommand,
    TENDON_STATE: TendonState,
    STATUS_KEY: Status,
    SIMULATOR_TRUTH: SimulatorTruth,
}
QUEUE = 64
POLL_SECONDS = 0.005
SHAPE_SECONDS = 0.05
PATIENCE_SECONDS = 10.0


def run_view(file: Path | None, config: Path | None, host: str, port: int) -> None:
    """Serve until a signal comes; see `tendond log view --help`.

    Raises:
        TendondError: the extra is missing, the port is taken, the log cannot be used, or there is no controller.
    """
    run = None if file is None else open_run(file)
    if run is not None and next(run.messages((CYCLE.topic,)), None) is None:
        raise no_cycles(run.paths[0])
    rig = load_config(config) if run is None else run.config
    server = _Server(CHANNELS if run is not None else LIVE, rig.rig.name, host, port)
    try:
        say(f"serving {run.paths[0] if run else f'rig {rig.rig.name!r}'} at ws://{host}:{server.port}")
        if run is not None:
            _play(run, server)
        else:
            _relay(rig, server)
    finally:
        server.stop()


class _Server:
    """Foxglove's server, with a channel for each of ours."""

    def __init__(self, channels: tuple[Channel[Any], ...], name: str, host: str, port: int) -> None:
        try:
            import foxglove as sdk
        except ImportError as error:
            raise UsageError("this needs Foxglove's SDK: pip install 'tendond[view]'") from error
        context = self._context = sdk.Context()  # its channels close with it
        try:
            self._server = sdk.start_server(name=f"tendond {name}", host=host, port=port, context=context)
        except (OSError, RuntimeError) as error:
            raise UsageError(f"cannot serve at {host}:{port}: {error}; choose another with --port") from error
        self.port = self._server.port
        self._channels = {
            channel.topic: sdk.Channel(
                channel.topic,
                message_encoding="json",
                schema=sdk.Schema(name=channel.schema_name, encoding="jsonschema", data=channel.schema()),
                context=context,
            )
            for channel in channels
        }

    def put(self, topic: str, data: bytes, time_ns: int) -> None:
        """A message to whoever watches."""
        if topic in self._channels:
            self._channels[topic].log(data, log_time=time_ns)

    def stop(self) -> None:
        """Say goodbye."""
        self._server.stop()


def _play(run: Run, server: _Server) -> None:
    """A log at the speed at which it was recorded, again and again."""
    topics = [channel.topic for channel in CHANNELS if channel.topic != "state"]
    while True:
        offset_ns: int | None = None
        for topic, message in run.messages(topics):
            now_ns = time.monotonic_ns()
            offset_ns = now_ns - message.log_time if offset_ns is None else offset_ns
            time.sleep(max(0, message.log_time + offset_ns - now_ns) / 1e9)
            server.put(topic, message.data, message.log_time)
        time.sleep(1.0)


def _relay(config: RigConfig, server: _Server) -> None:
    """What is on the bus; the rod is the model's under the commanded tensions, computed here."""
    name = config.rig.name
    rod = rod_from_section(config.rod, config.loop.period)
    state = rod.solve_static([0.0] * rod.parameters.tendon_count)
    target = (0.0, 0.0, 0.0)
    tip: TipPose | None = None
    trail: deque[Vector3] = deque(maxlen=foxglove.TRAIL_POINTS)
    next_shape = 0.0
    with open_client(config.bus.endpoint, PATIENCE_SECONDS) as session:
        subscriptions = [Subscription[Any](session, key(name, topic), kind, QUEUE) for topic, kind in KINDS.items()]
        while True:
            for subscription in subscriptions:
                for message in subscription:
                    now_ns = time.time_ns()
                    match message:
                        case TipPose():
                            tip = message
                            pose = foxglove.pose_in_frame(now_ns, message.position, message.orientation)
                            server.put(TIP_MEASURED.topic, encode(pose), now_ns)
                        case TendonCommand():
                            server.put(COMMAND.topic, encode(message), now_ns)
                            try:
                                state = rod.step(state, [max(0.0, pull) for pull in message.tension])
                            except ModelError:
                                continue  # the picture stays where it was
                        case TendonState():
                            server.put(TENDONS.topic, encode(message), now_ns)
                        case Status():
                            target = message.target
                            server.put(STATUS.topic, encode(message), now_ns)
                        case SimulatorTruth():
                            server.put(TRUTH.topic, encode(message), now_ns)
            if time.monotonic() >= next_shape:
                next_shape = time.monotonic() + SHAPE_SECONDS
                now_ns = time.time_ns()
                points, end = rod.curve(state), rod.tip(state)
                x, y, z = end.position.tolist()
                place = ((x, y, z), quaternion(end.rotation))
                tendons = foxglove.tendon_paths(state.rotations, points, rod.parameters.tendon_positions)
                trail.append(place[0] if tip is None else tip.position)
                scene = foxglove.rod_shape(now_ns, state.count, points, target, tendons, trail)
                server.put(ROD_SHAPE.topic, encode(scene), now_ns)
                server.put(TIP_MODEL.topic, encode(foxglove.pose_in_frame(now_ns, *place)), now_ns)
                frames = {"tip_model": place}
                if tip is not None:
                    frames["tip_measured"] = (tip.position, tip.orientation)
                server.put(TRANSFORMS.topic, encode(foxglove.frame_transforms(now_ns, frames)), now_ns)
            time.sleep(POLL_SECONDS)
