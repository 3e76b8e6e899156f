"""Recovery of the intact part of a truncated or damaged file into a new one."""

from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import Attachment, Channel, Footer, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from tendond import __version__
from tendond.daemon.errors import UsageError
from tendond.daemon.recording.channels import CYCLE, STATE
from tendond.daemon.recording.mcap_file import CHUNK_BYTES
from tendond.offline.files import whole
from tendond.offline.logs.container import Damage, LogError, records
from tendond.offline.logs.ticks import left_out_before, ranges, tick_of


@dataclass
class Recovered:
    """Result of recovering a file.

    Attributes:
        messages: kept.
        cycles: cycles among them.
        complete: the old file was finished.
        damage: the damaged stretches.
        missing: ticks that are not there, between the first and the last that are; first and last of each stretch.
        first, last: ticks kept; none without a cycle.
    """

    messages: int = 0
    cycles: int = 0
    complete: bool = False
    damage: list[Damage] = field(default_factory=list)
    missing: list[tuple[int, int]] = field(default_factory=list)
    first: int | None = None
    last: int | None = None


def recover(path: Path, out: Path) -> Recovered:
    """Write every whole record of a file into a new, finished file.

    Raises:
        LogError: it is not an MCAP file, or nothing in it is whole.
        UsageError: the new file exists already, or cannot be written.
    """
    found = Recovered()
    ticks: list[int] = []
    left_out: list[tuple[int, int]] = []
    try:
        if out.exists():
            raise FileExistsError
        with whole(out) as draft, draft.open("wb") as stream:
            writer = Writer(stream, chunk_size=CHUNK_BYTES, compression=CompressionType.ZSTD)
            writer.start(library=f"tendond {__version__}")
            schemas, channels, topics = {0: 0}, {}, {}
            for record in records(path):
                match record:
                    case Damage():
                        found.damage.append(record)
                    case Schema():
                        if record.id not in schemas:
                            schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
                    case Channel():
                        if record.id not in channels:
                            channels[record.id] = writer.register_channel(
                                record.topic, record.message_encoding, schemas.get(record.schema_id, 0), record.metadata
                            )
                            topics[record.id] = record.topic
                    case Metadata():
                        writer.add_metadata(record.name, record.metadata)
                    case Attachment():
                        writer.add_attachment(
                            record.create_time, record.log_time, record.name, record.media_type, record.data
                        )
                    case Footer():
                        found.complete = True
                    case Message() if record.channel_id in channels:
                        writer.add_message(
                            channels[record.channel_id],
                            record.log_time,
                            record.data,
                            record.publish_time,
                            record.sequence,
                        )
                        found.messages += 1
                        topic = topics[record.channel_id]
                        if topic == CYCLE.topic and (tick := tick_of(record.data)) is not None:
                            ticks.append(tick)
                        elif topic == STATE.topic and (stretch := left_out_before(record.data)) is not None:
                            left_out.append(stretch)
            writer.finish()
            if not found.messages:
                raise LogError(f"{path}: nothing in it is whole, so nothing can be saved; use another log")
    except FileExistsError as error:
        raise UsageError(f"{out}: exists already; choose another file with --out") from error
    except OSError as error:
        raise UsageError(f"{out}: cannot be written: {error.strerror}; choose another file with --out") from error
    found.cycles = len(ticks)
    if ticks:
        found.first, found.last = ticks[0], ticks[-1]
        found.missing = [stretch for stretch in ranges(ticks) if stretch not in left_out]
    return found
