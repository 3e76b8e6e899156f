"""Reading a log, whole or of a process that was killed."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Attachment, Footer, Header, McapRecord, Message, Metadata
from mcap.records import Channel as ChannelRecord
from mcap.stream_reader import StreamReader
from numpy.typing import NDArray
from pydantic import ValidationError

from tendond.daemon import foxglove
from tendond.daemon.channels import CYCLE, LOG, ROD_SHAPE, TIMING, TRUTH, Channel, M
from tendond.daemon.errors import DaemonError
from tendond.daemon.recorder import CONFIG, METADATA
from tendond.schemas.config import ConfigError, RigConfig, check_config
from tendond.schemas.explain import explain
from tendond.schemas.messages import SimulatorTruth
from tendond.schemas.record import CycleRecord, LoopTiming

Array = NDArray[np.float64]

READ: tuple[Channel[Any], ...] = (CYCLE, TIMING, ROD_SHAPE, TRUTH, LOG)


class LogError(DaemonError):
    """A log that cannot be used: file, what is wrong, what to do."""


@dataclass(frozen=True)
class Log:
    """What a run left behind, in the order in which it was written.

    Attributes:
        path: of the file.
        complete: it was finished; if not, its end is missing (writer killed, disk full).
        config: of the rig.
        metadata: revision and versions, by name.
        records: of the cycles; at least one.
        timings: of the loop.
        shapes: tick and points of the rod, base to tip [m], shape (points, 3).
        truth: of the simulator; empty on a rig.
        log_lines: for people.
    """

    path: Path
    complete: bool
    config: RigConfig
    metadata: dict[str, str]
    records: list[CycleRecord]
    timings: list[LoopTiming]
    shapes: list[tuple[int, Array]]
    truth: list[SimulatorTruth]
    log_lines: list[foxglove.Log]


def load(path: Path) -> Log:
    """Read a log of the recorder's.

    Raises:
        LogError: no file, not an MCAP file, not one of ours, without configuration or cycles, or of another version.
    """
    complete = False
    config: RigConfig | None = None
    metadata: dict[str, str] | None = None
    topics: dict[int, str] = {}
    models = {channel.topic: channel.model for channel in READ}
    messages: dict[str, list[Any]] = {channel.topic: [] for channel in READ}
    for record in _records(path):
        match record:
            case Metadata(name=name) if name == METADATA:
                metadata = record.metadata
            case Attachment(name=name) if name == CONFIG:
                config = _config(path, record.data)
            case ChannelRecord():
                topics[record.id] = record.topic
            case Message():
                topic = topics.get(record.channel_id, "")
                if metadata is not None and topic in models:
                    messages[topic].append(_decode(path, topic, models[topic], record.data))
            case Footer():
                complete = True
    if metadata is None:
        raise LogError(f"{path}: is an MCAP file, but not of tendond; give a log that 'tendond run' has written")
    if config is None:
        raise LogError(f"{path}: has no configuration ('{CONFIG}'), so its start is lost; use another log")
    if not messages[CYCLE.topic]:
        raise LogError(f"{path}: holds no cycles, the run ended before its first half second; record another one")
    return Log(
        path=path,
        complete=complete,
        config=config,
        metadata=metadata,
        records=messages[CYCLE.topic],
        timings=messages[TIMING.topic],
        shapes=[_shape(path, scene) for scene in messages[ROD_SHAPE.topic]],
        truth=messages[TRUTH.topic],
        log_lines=messages[LOG.topic],
    )


def _records(path: Path) -> Iterator[McapRecord]:
    """The records of the file up to its end, or to where it is cut off or damaged."""
    try:
        with path.open("rb") as stream:
            # No record is longer than the file: a damaged length is no reason to ask for all of the memory.
            reader = StreamReader(stream, validate_crcs=True, record_size_limit=path.stat().st_size)
            started = False
            try:
                for record in reader.records:
                    started = started or isinstance(record, Header)
                    yield record
            except Exception as error:
                # mcap meets a cut or damaged end with any of a dozen errors (EndOfFile, struct.error, zstd's own...);
                # what stands before it is whole, its checksums say so.
                if not started:
                    raise LogError(f"{path}: is no MCAP file; give a log that 'tendond run' has written") from error
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}; check name and permissions") from error


def _config(path: Path, data: bytes) -> RigConfig:
    try:
        return check_config(json.loads(data), CONFIG)
    except ValueError as error:
        raise LogError(f"{path}: its configuration is no JSON: {error}; use another log") from error
    except ConfigError as error:
        lines = "; ".join(str(error).splitlines())
        raise LogError(f"{path}: {lines}; read it with the version of tendond that wrote it") from error


def _decode(path: Path, topic: str, model: type[M], data: bytes) -> M:
    try:
        return model.model_validate_json(data)
    except ValidationError as error:
        line = explain(error, model)[0]
        raise LogError(
            f"{path}: message on '{topic}': {line}; read the log with the version of tendond that wrote it"
        ) from error


def _shape(path: Path, scene: foxglove.SceneUpdate) -> tuple[int, Array]:
    """Tick and points of the rod in a scene."""
    for entity in scene.entities:
        ticks = [pair.value for pair in entity.metadata if pair.key == foxglove.TICK]
        if entity.id == foxglove.ROD and ticks and entity.lines:
            return int(ticks[0]), np.array([(point.x, point.y, point.z) for point in entity.lines[0].points])
    raise LogError(f"{path}: a scene on '{ROD_SHAPE.topic}' has no rod; read it with the version that wrote it")
