"""The files of a run: its configuration, metadata and messages, whole, in parts, or cut off."""

import glob
import json
import re
import warnings
from collections.abc import Collection, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Attachment, Footer, Message, Metadata
from mcap.records import Channel as ChannelRecord
from mcap.summary import Summary
from pydantic import ValidationError

from tendond.daemon.recording.channels import M
from tendond.daemon.recording.mcap_file import METADATA
from tendond.daemon.recording.run_files import CALIBRATION, CONFIG, FORMAT, LOG_FORMAT, PART, run_name
from tendond.offline.logs.container import Damage, records
from tendond.offline.logs.container import LogError as LogError
from tendond.schemas.calibration import Calibration
from tendond.schemas.config.renamed import RenamedKeyWarning
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config
from tendond.schemas.errors.explain import explain


def no_cycles(path: Path, *, complete: bool = True) -> LogError:
    """Return the error of a log without cycles; `complete`: it was finished."""
    if not complete:
        size = path.stat().st_size
        return LogError(f"{path}: was cut off after {size} bytes, before its first cycles were whole; use another log")
    return LogError(f"{path}: contains no cycles, the run ended within half a second; record another one")


@dataclass
class Run:
    """The files of one run, their configuration and metadata.

    Attributes:
        paths: the files, in the order in which they were written.
        config: the rig's configuration.
        attachment: the configuration as text, as in the file.
        metadata: revision and versions, by name.
        calibration: the servos' calibration; none without servos.
        complete: the last file was finished; known once all messages have been read.
        name: of the run: that of its first file, without `.mcap`, whether that is still there or not.
    """

    paths: tuple[Path, ...]
    config: RigConfig
    attachment: bytes
    metadata: dict[str, str]
    calibration: Calibration | None = None
    complete: bool = False
    name: str = ""

    def decode(self, topic: str, model: type[M], data: bytes) -> M:
        """Decode a message.

        Raises:
            LogError: not a message of this model, or of another version.
        """
        return decode(self.paths[0], topic, model, data)

    def messages(self, topics: Collection[str], start_ns: int = 0) -> Iterator[tuple[str, Message]]:
        """Yield the messages of these topics, file after file.

        Args:
            topics: whose messages are wanted.
            start_ns: log time from which on they are wanted [ns]; only whole chunks before it are passed over,
                so a few earlier ones may come.

        Raises:
            LogError: a part is damaged; a file that is cut off at its end is not an error.
        """
        for path in self.paths:
            self.complete = False
            names: dict[int, str] = {}
            if start_ns > 0 and (summary := _summary(path)) is not None:  # a chunk that is passed over may define some
                names = {number: channel.topic for number, channel in summary.channels.items()}
            for record in records(path, topics, start_ns):
                match record:
                    case Message():
                        if (topic := names[record.channel_id]) in topics:
                            yield topic, record
                    case ChannelRecord():
                        names[record.id] = record.topic
                    case Footer():
                        self.complete = True
                    case Damage(cut=False):
                        raise LogError(f"{path}: {record}; 'tendond log recover {path}' recovers the intact part")

    def last_time(self) -> int | None:
        """Return the time of the last message [ns]; none where the last file is not finished."""
        summary = _summary(self.paths[-1])
        return None if summary is None or summary.statistics is None else summary.statistics.message_end_time


def open_run(path: Path, *, whole: bool = True) -> Run:
    """Open the run that a file belongs to: the file, or all parts of a split log in its folder.

    Args:
        path: any file of the run.
        whole: all parts; else this file alone.

    Raises:
        LogError: no file, not an MCAP file, not a log of tendond, or without configuration.
    """
    metadata, attachments = _head(path)
    _refuse_newer(path, metadata)
    if CONFIG not in attachments:
        raise LogError(f"{path}: has no configuration ('{CONFIG}'), so its start is lost; use another log")
    attached = attachments.get(CALIBRATION)
    calibration = None if attached is None else _calibration(path, attached)
    config = _config(path, attachments[CONFIG])
    parts, name = _parts(path, metadata) if whole else (path,), run_name(path, part_of(metadata))
    return Run(parts, config, attachments[CONFIG], metadata, calibration, name=name)


def part_of(metadata: dict[str, str]) -> int:
    """Return the number of a file in its run, from 0; logs of the first versions have none."""
    number = metadata.get(PART, "")
    return int(number) if number.isdecimal() else 0


def _refuse_newer(path: Path, metadata: dict[str, str]) -> None:
    """Raise LogError for a log that a later version of tendond wrote in another form."""
    version = metadata.get(FORMAT, "")
    if version.isdecimal() and int(version) > LOG_FORMAT:
        raise LogError(
            f"{path}: is a log of format {version}, and this tendond reads formats up to {LOG_FORMAT}: "
            f"read it with tendond {metadata.get('tendond', 'of a later version')} or later"
        )


def _summary(path: Path) -> Summary | None:
    """Return the summary at the end of a file; none where it is not finished."""
    with suppress(McapError, OSError), path.open("rb") as stream:
        return make_reader(stream).get_summary()
    return None


def _head(path: Path) -> tuple[dict[str, str], dict[str, bytes]]:
    """Read metadata and attachments by name, before the first message or, if another program rewrote the file, at its
    end."""
    metadata: dict[str, str] | None = None
    attachments: dict[str, bytes] = {}
    cut = False
    for record in records(path):
        match record:
            case Damage(cut=True):
                cut = True
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
    if cut and (metadata is None or CONFIG not in attachments):
        raise LogError(
            f"{path}: was cut off after {path.stat().st_size} bytes, before its first record; it holds no run"
        )
    if metadata is None:
        raise LogError(f"{path}: is an MCAP file, but not a log of tendond; give a file that 'tendond run' has written")
    return metadata, attachments


def _parts(path: Path, metadata: dict[str, str]) -> tuple[Path, ...]:
    """Find all files of the run in the folder: `run.mcap`, `run-001.mcap`, ..., with the same metadata."""
    number = metadata.get(PART, "")
    if not number.isdecimal():
        return (path,)
    stem = run_name(path, int(number))
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
            warnings.simplefilter("ignore", RenamedKeyWarning)  # a log is not to be edited
            return check_config(_with_its_rules(json.loads(data)), CONFIG)
    except ValueError as error:
        raise LogError(f"{path}: its configuration is not valid JSON: {error}; use another log") from error
    except ConfigError as error:
        lines = "; ".join(str(error).splitlines())
        raise LogError(f"{path}: {lines}; read it with the version of tendond that wrote it") from error


def _with_its_rules(data: Any) -> Any:
    """Return a recorded configuration with the rules that held when it was written: 1 before they had a number."""
    if not isinstance(data, dict) or not isinstance(control := data.get("control", {}), dict) or "rules" in control:
        return data
    return {**data, "control": {**control, "rules": 1}}


def _calibration(path: Path, data: bytes) -> Calibration:
    try:
        return Calibration.model_validate_json(data)
    except ValidationError as error:
        line = explain(error, Calibration)[0]
        raise LogError(f"{path}: {CALIBRATION}: {line}; read it with the version of tendond that wrote it") from error


def decode(path: Path, topic: str, model: type[M], data: bytes) -> M:
    try:
        return model.model_validate_json(data)
    except ValidationError as error:
        line = explain(error, model)[0]
        raise LogError(
            f"{path}: message on '{topic}': {line}; read the log with the version of tendond that wrote it"
        ) from error
