"""A log as a rosbag2 folder: metadata.yaml and an MCAP file with CDR messages, which ROS 2's tools read.

Format: rosbag2's metadata of version 8, whose profiles of quality of service are texts as Humble expects them; later
distributions read it as well. Written by `rosbags` (https://ternaris.gitlab.io/rosbags).
"""

import os
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from mcap.records import Message
from rosbags.interfaces import (
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import StoragePlugin, Writer

from tendond.daemon.errors import DaemonError, UsageError
from tendond.daemon.recording.channels import CYCLE, ROD_SHAPE, STATUS
from tendond.drivers.ros2.description import controller_health, cycle_health, urdf
from tendond.drivers.ros2.messages import Place, RigMessages
from tendond.drivers.ros2.topics import RigTopics, Topic
from tendond.drivers.ros2.types import types_of
from tendond.offline.logs.log import scene_points
from tendond.offline.logs.run import Run, no_cycles, open_run
from tendond.schemas.base import Vector3
from tendond.schemas.record import CycleRecord

Entry = tuple[Topic, int, Any]
"""Topic, wall-clock time at which the message was recorded [ns], and the message."""

HEALTH_SECONDS = 1.0
"""Time between two diagnostics from the records of cycles, beside those at each change of mode [s]."""

LAG_MAX = 1.0
"""Largest age of a pose that its stamp is moved back by [s]; the clock of a camera's host may be another one."""


def check_bag(path: Path) -> None:
    """Check that a bag can be written to a folder, before a log is read for it.

    Raises:
        UsageError: it exists, or its name ends like a file's.
    """
    if path.suffix in (".csv", ".parquet", ".mcap"):
        raise UsageError(f"{path}: --rosbag2 writes a folder: give a name without {path.suffix}")
    if path.exists():
        raise UsageError(f"{path}: exists already: choose another folder with --out, or remove it")


def export_bag(log: Path, path: Path, distribution: str) -> Counter[str]:
    """Write a log as a rosbag2 folder; return the number of messages by topic.

    Args:
        log: any file of the run.
        path: the new folder, which appears when it is whole.
        distribution: whose message definitions are used.

    Raises:
        LogError: the log cannot be used. UsageError: see `check_bag`. DaemonError: the folder cannot be written.
    """
    check_bag(path)
    run = open_run(log)
    try:
        with tempfile.TemporaryDirectory(dir=path.resolve().parent, prefix=f".{path.name}-") as draft:
            counts = _write(run, Path(draft) / path.name, distribution)
            os.rename(Path(draft) / path.name, path)
    except OSError as error:
        raise DaemonError(f"{path}: cannot be written: {error.strerror}; choose another folder with --out") from error
    if not counts:
        raise no_cycles(log, complete=run.complete)
    return counts


def _write(run: Run, path: Path, distribution: str) -> Counter[str]:
    types = types_of(distribution)
    counts: Counter[str] = Counter()
    with Writer(path, version=8, storage_plugin=StoragePlugin.MCAP) as bag:
        bag.set_custom_data("tendond", run.metadata.get("tendond", ""))
        connections = {}
        for topic, time_ns, message in _entries(run, RigMessages(types, run.config.rig.name)):
            if topic not in connections:
                connections[topic] = bag.add_connection(
                    topic.name, topic.type_name, typestore=types.store, offered_qos_profiles=[_qos(topic)]
                )
            bag.write(connections[topic], time_ns, types.encode(message))
            counts[topic.name] += 1
    return counts


def _entries(run: Run, messages: RigMessages) -> Iterator[Entry]:
    """Yield the messages of a run in the order of the log, behind the description of the robot."""
    topics, target = RigTopics(run.config.rig.name), (0.0, 0.0, 0.0)
    first, told, said = True, 0.0, ""
    for topic, message in run.messages((CYCLE.topic, STATUS.topic, ROD_SHAPE.topic)):
        now = message.log_time
        if first:
            first = False
            yield topics.description, now, messages.text(urdf(run.config, messages))
        if topic == CYCLE.topic:
            record = run.decode(topic, CycleRecord, message.data)
            target = record.reference.target
            yield from _cycle(topics, messages, now, record)
            words = f"{record.mode.value}: {record.reason}"
            if words != said or record.time - told >= HEALTH_SECONDS:  # a log without a clock has no status
                said, told = words, record.time
                yield topics.diagnostics, now, messages.diagnostics(now, [cycle_health(run.config.rig.name, record)])
        elif topic == STATUS.topic:
            status = run.decode(topic, STATUS.model, message.data)
            yield topics.diagnostics, now, messages.diagnostics(now, [controller_health(status)])
        else:
            yield topics.rod, now, _shape(run, messages, message, target)


def _cycle(topics: RigTopics, messages: RigMessages, now: int, record: CycleRecord) -> Iterator[Entry]:
    """Yield the messages of a cycle: what came in, what was estimated, what was commanded."""
    model = (record.model.position, record.model.orientation)
    frames: dict[str, Place] = {messages.model_tip: model}
    if (pose := record.inputs.pose) is not None and pose.valid:
        lag = record.inputs.pose_lag
        taken = now - round(1e9 * lag) if lag is not None and 0.0 <= lag <= LAG_MAX else now
        place = (pose.position, pose.orientation)
        frames[messages.tip] = place
        yield topics.tip_pose, now, messages.pose(taken, place)
    if (state := record.inputs.tendon_state) is not None:
        yield topics.tendon_state, now, messages.joints(now, state.displacement, state.tension)
    yield topics.transforms, now, messages.transforms(now, frames)
    if (known := record.observer.filter) is not None:
        yield topics.tip_estimate, now, messages.estimate(now, model, known.tip_covariance)
    yield topics.reference, now, messages.point(now, record.reference.position)
    yield topics.tendon_command, now, messages.joints(now, record.command.displacement, record.command.tension)


def _shape(run: Run, messages: RigMessages, message: Message, target: Vector3) -> Any:
    update = run.decode(ROD_SHAPE.topic, ROD_SHAPE.model, message.data)
    _, (rod, *tendons) = scene_points(run.paths[0], update)
    return messages.markers(message.log_time, rod, tendons, target)


def _qos(topic: Topic) -> Qos:
    never = QosTime(9223372036, 854775807)  # RMW_DURATION_INFINITE of rmw/time.h: the largest int64 in nanoseconds
    return Qos(
        QosHistory.KEEP_LAST,
        topic.qos.depth,
        QosReliability.RELIABLE,
        QosDurability.TRANSIENT_LOCAL if topic.qos.latched else QosDurability.VOLATILE,
        never,
        never,
        QosLiveliness.AUTOMATIC,
        never,
        avoid_ros_namespace_conventions=False,
    )
