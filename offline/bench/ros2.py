"""Time from a pose on the bus to the same pose in ROS 2, through the bridge: `tendond bench ros2`."""

import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import zenoh

from tendond.bus.client import open_client
from tendond.daemon.errors import DaemonError
from tendond.drivers.ros2.names import topic_key
from tendond.drivers.ros2.topics import RigTopics
from tendond.drivers.ros2.types import types_of
from tendond.offline.bench.bare import Quantiles
from tendond.offline.bench.rigs import RIG, PunctualityRow, configure, process
from tendond.offline.processes import START_SECONDS, free_port
from tendond.schemas.config.presets import PAPER
from tendond.schemas.keys import TENDON_COMMAND, TIP_POSE, key
from tendond.schemas.messages import TendonCommand, TipPose
from tendond.schemas.wire import decode, encode

PERIOD = 0.01
"""Period of poses and commands [s]: those of the paper's rig."""

COUNT, WARM_UP = 2000, 100
ANSWER_SECONDS = 0.001
"""Time from a pose to the command for it, after which the bridge is busy with the rod [s]; about the controller's."""


def measure_bridge(progress: Callable[[str], None], count: int = COUNT) -> PunctualityRow:
    """Time poses to their arrival in ROS 2, beside that of the same poses at a subscriber of the bus.

    Poses and commands come at the paper's rate; the bridge is a process of its own, bus and router are sessions here.

    Raises:
        TendondError: a process could not be started.
    """
    progress("poses to ROS 2")
    router = f"tcp/127.0.0.1:{free_port()}"
    with tempfile.TemporaryDirectory() as name:
        config, _, endpoint = configure(Path(name), "bridge", PAPER)
        with (
            _listening("peer", endpoint),
            _listening("router", router),
            process("tendond.cli", "bridge", "ros2", "--config", str(config), "--router", router),
            open_client(endpoint, START_SECONDS) as bus,
            open_client(router, START_SECONDS) as ros,
        ):
            return _timed(bus, ros, count)


def _timed(bus: zenoh.Session, ros: zenoh.Session, count: int) -> PunctualityRow:
    types, topic = types_of("jazzy"), RigTopics(RIG).tip_pose
    direct: dict[int, int] = {}
    through: dict[int, int] = {}

    def on_bus(sample: zenoh.Sample) -> None:
        now = time.monotonic_ns()
        direct[round(decode(TipPose, sample.payload.to_bytes()).position[0])] = now

    def in_ros(sample: zenoh.Sample) -> None:
        now = time.monotonic_ns()
        through[round(types.decode(topic.type_name, sample.payload.to_bytes()).pose.position.x)] = now

    expression = topic_key(0, topic.name, topic.type_name, types.hash_of(topic.type_name))
    subscriptions = (bus.declare_subscriber(key(RIG, TIP_POSE), on_bus), ros.declare_subscriber(expression, in_ros))
    poses = bus.declare_publisher(key(RIG, TIP_POSE), express=True)
    commands = bus.declare_publisher(key(RIG, TENDON_COMMAND), express=True)
    sent: dict[int, int] = {}
    deadline, give_up = time.monotonic(), time.monotonic() + START_SECONDS
    number = 0
    while number < count + WARM_UP:
        if not through and time.monotonic() > give_up:
            raise DaemonError("no pose comes through the bridge: run 'tendond bridge ros2' by hand to see why")
        number += bool(through)  # the number is the pose's x: a message of ROS has no other place for it
        now = time.monotonic_ns()
        pose = TipPose(seq=number, stamp_ns=now, position=(number, 0.0, 0.0), orientation=(1.0, 0.0, 0.0, 0.0))
        sent[number] = time.monotonic_ns()
        poses.put(encode(pose))
        time.sleep(ANSWER_SECONDS)
        command = TendonCommand(
            seq=number, stamp_ns=now, pose_seq=number, displacement=(0.0,) * 4, tension=(5.0, 0.5, 0.5, 0.5), armed=True
        )
        commands.put(encode(command))
        deadline = max(deadline + PERIOD, time.monotonic())
        time.sleep(max(0.0, deadline - time.monotonic()))
    for one in subscriptions:
        one.undeclare()
    both = [one for one in sorted(sent) if one > WARM_UP and one in direct and one in through]
    added = 1e-3 * np.array([through[one] - direct[one] for one in both])
    median, p99 = np.percentile(added, [50.0, 99.0])
    return PunctualityRow(
        "pose to ROS 2 through the bridge, bare: to a subscriber of the bus",
        Quantiles.of([1e-3 * (through[one] - sent[one]) for one in both]),
        Quantiles.of([1e-3 * (direct[one] - sent[one]) for one in both]),
        f"{len(both)} of {count} poses; the bridge adds {median:.0f} us, p99 {p99:.0f} us",
    )


def _listening(mode: str, endpoint: str) -> zenoh.Session:
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps(mode))
    config.insert_json5("listen/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    return zenoh.open(config)
