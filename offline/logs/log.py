"""Reading a log, whole, in parts, or of a process that was killed."""

import glob
import json
import os
import re
import warnings
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Attachment, Footer, Message, Metadata
from mcap.records import Channel as ChannelRecord
from numpy.typing import NDArray
from pydantic import ValidationError

from tendond.daemon.recording import foxglove
from tendond.daemon.recording.channels import CYCLE, LOG, ROD_SHAPE, TIMING, TRUTH, Channel, M
from tendond.daemon.recording.mcap_file import METADATA
from tendond.daemon.recording.recorder import CALIBRATION, CONFIG, PART
from tendond.offline.logs.container import Damage, records
from tendond.offline.logs.container import LogError as LogError
from tendond.schemas.calibration import Calibration
from tendond.schemas.config.renamed import RenamedKeyWarning
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config
from tendond.schemas.errors.explain import explain
from tendond.schemas.messages import SimulatorTruth
from tendond.schemas.record import CycleRecord, LoopTiming

Array = NDArray[np.float64]

READ: tuple[Channel[Any], ...] = (CYCLE, TIMING, ROD_SHAPE, TRUTH, LOG)


@dataclass(frozen=True)
class LogFile:
    """A run's log, in the order in which it was written.

    Attributes:
        path: the file.
        complete: it was finished; if not, its end is missing (writer killed, disk full).
        config: the rig's configuration.
        metadata: revision and versions, by name.
        calibration: the servos' calibration; none without servos.
        records: the cycles' records; not empty.
        timings: the loop's timings.
        shapes: tick and points of the rod, base to tip [m], shape (points, 3).
        tendons: points of each tendon, for each shape [m], shapes (k, 3).
        truth: the simulator's truth; empty on a rig.
        log_lines: the log lines for people.
    """

    path: Path
    complete: bool
    config: RigConfig
    metadata: dict[str, str]
    calibration: Calibration | None
    records: list[CycleRecord]
    timings: list[LoopTiming]
    shapes: list[tuple[int, Array]]
    tendons: list[list[Array]]
    truth: list[SimulatorTruth]
    log_lines: list[foxglove.Log]

    @property
    def name(self) -> str:
        """Name of the file, as text that can be printed in any locale."""
        return as_text(self.path.name)


def as_text(name: str) -> str:
    """A file's name as it is on the disk, which is UTF-8 as a rule; what is not is replaced."""
    return os.fsencode(name).decode("utf-8", errors="replace")


def load(path: Path) -> LogFile:
    """Read a log of the recorder's, with all the files that it was spread over.

    Raises:
        LogError: no file, not an MCAP file, not one of ours, damaged, without configuration or cycles, or of another
            version.
    """
    models = {channel.topic: channel.model for channel in READ}
    messages: dict[str, list[Any]] = {channel.topic: [] for channel in READ}
    run = open_run(path)
    for topic, message in run.messages(tuple(models)):
        messages[topic].append(_decode(path, topic, models[topic], message.data))
    if not messages[CYCLE.topic]:
        raise no_cycles(path)
    scenes = [_scene(path, scene) for scene in messages[ROD_SHAPE.topic]]
    return LogFile(
        path=path,
        complete=run.complete,
        config=run.config,
        metadata=run.metadata,
        calibration=run.calibration,
        records=messages[CYCLE.topic],
        timings=messages[TIMING.topic],
        shapes=[(tick, lines[0]) for tick, lines in scenes],
        tendons=[lines[1:] for _, lines in scenes],
        truth=messages[TRUTH.topic],
        log_lines=messages[LOG.topic],
    )


def no_cycles(path: Path) -> LogError:
    """The error of a log in which nothing is."""
    return LogError(f"{path}: holds no cycles, the run ended before its first half second; record another one")


@dataclass
class Run:
    """The files of one run, their configuration and metadata.

    Attributes:
        paths: the files, in the order in which they were written.
        config: the rig's configuration.
        attachment: the configuration as it stands in the file.
        metadata: revision and versions, by name.
        calibration: the servos' calibration; none without servos.
        complete: the last file was finished; known once all messages have been read.
    """

    paths: tuple[Path, ...]
    config: RigConfig
    attachment: bytes
    metadata: dict[str, str]
    calibration: Calibration | None = None
    complete: bool = False

    def decode(self, topic: str, model: type[M], data: bytes) -> M:
        """A message; raises LogError where it is none, or of another version."""
        return _decode(self.paths[0], topic, model, data)

    def messages(self, topics: Collection[str]) -> Iterator[tuple[str, Message]]:
        """The messages of these topics, file after file.

        Raises:
            LogError: a part is damaged; what is cut off at the end of a file is not an error.
        """
        for path in self.paths:
            self.complete = False
            names: dict[int, str] = {}
            for record in records(path, topics):
                match record:
                    case Message():
                        yield names[record.channel_id], record
                    case ChannelRecord():
                        names[record.id] = record.topic
                    case Footer():
                        self.complete = True
                    case Damage(cut=False):
                        raise LogError(f"{path}: {record}; 'tendond log recover {path}' saves what is whole")


def open_run(path: Path) -> Run:
    """The run that a file is of: the file, or all the parts in its folder where the recorder began new ones.

    Raises:
        LogError: no file, not an MCAP file, not one of ours, without configuration.
    """
    metadata, attachments = _head(path)
    if CONFIG not in attachments:
        raise LogError(f"{path}: has no configuration ('{CONFIG}'), so its start is lost; use another log")
    attached = attachments.get(CALIBRATION)
    calibration = None if attached is None else _calibration(path, attached)
    return Run(_parts(path, metadata), _config(path, attachments[CONFIG]), attachments[CONFIG], metadata, calibration)


def _head(path: Path) -> tuple[dict[str, str], dict[str, bytes]]:
    """Metadata and attachments by name: what stands before the first message, or, where another program has rewritten
    the file, at its end."""
    metadata: dict[str, str] | None = None
    attachments: dict[str, bytes] = {}
    for record in records(path):
        match record:
            case Metadata(name=name) if name == METADATA:
                metadata = record.metadata
            case Attachment():
                attachments[record.name] = record.data
            case Damage(cut=False) if metadata is None or CONFIG not in attachments:
                raise LogError(f"{path}: {record}, at its start; use another log")
            case Message():
                break
    if metadata is None or CONFIG not in attachments:
        with suppress(McapError, OSError), path.open("rb") as stream:
            reader = make_reader(stream)
            metadata = metadata or next((one.metadata for one in reader.iter_metadata() if one.name == METADATA), None)
            attachments = attachments or {one.name: one.data for one in reader.iter_attachments()}
    if metadata is None:
        raise LogError(f"{path}: is an MCAP file, but not of tendond; give a log that 'tendond run' has written")
    return metadata, attachments


def _parts(path: Path, metadata: dict[str, str]) -> tuple[Path, ...]:
    """All files of the same run in the same folder: `run.mcap`, `run-001.mcap`, ..., with the same metadata."""
    number = metadata.get(PART, "")
    if not number.isdecimal():
        return (path,)
    stem = path.stem if number == "0" else path.stem.removesuffix(f"-{int(number):03d}")
    found = {int(number): path}
    for other in path.parent.glob(f"{glob.escape(stem)}*{path.suffix}"):
        match = re.fullmatch(rf"{re.escape(stem)}(?:-(\d{{3,}}))?", other.stem)
        if match is None or other == path:
            continue
        part = int(match[1] or 0)
        try:
            theirs = _head(other)[0]
        except LogError:  # the last part may have been cut off before its header
            continue
        if theirs == {**metadata, PART: str(part)}:
            found[part] = other
    return tuple(found[part] for part in sorted(found))


def _config(path: Path, data: bytes) -> RigConfig:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RenamedKeyWarning)  # nobody is to edit a log
            return check_config(json.loads(data), CONFIG)
    except ValueError as error:
        raise LogError(f"{path}: its configuration is no JSON: {error}; use another log") from error
    except ConfigError as error:
        lines = "; ".join(str(error).splitlines())
        raise LogError(f"{path}: {lines}; read it with the version of tendond that wrote it") from error


def _calibration(path: Path, data: bytes) -> Calibration:
    try:
        return Calibration.model_validate_json(data)
    except ValidationError as error:
        line = explain(error, Calibration)[0]
        raise LogError(f"{path}: {CALIBRATION}: {line}; read it with the version of tendond that wrote it") from error


def _decode(path: Path, topic: str, model: type[M], data: bytes) -> M:
    try:
        return model.model_validate_json(data)
    except ValidationError as error:
        line = explain(error, model)[0]
        raise LogError(
            f"{path}: message on '{topic}': {line}; read the log with the version of tendond that wrote it"
        ) from error


def _scene(path: Path, scene: foxglove.SceneUpdate) -> tuple[int, list[Array]]:
    """Tick, and points of the rod and of its tendons, in a scene."""
    for entity in scene.entities:
        ticks = [pair.value for pair in entity.metadata if pair.key == foxglove.TICK]
        if entity.id == foxglove.ROD and ticks and entity.lines:
            lines = [np.array([(point.x, point.y, point.z) for point in line.points]) for line in entity.lines]
            return int(ticks[0]), lines
    raise LogError(f"{path}: a scene on '{ROD_SHAPE.topic}' has no rod; read it with the version that wrote it")
