"""Logs made from logs: with messages changed or left out, or spread over several files."""

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import Writer

from tendond.daemon.recording.channels import CYCLE, STATE
from tendond.daemon.recording.run_files import CALIBRATION, CONFIG
from tendond.offline.logs.container import records

Change = Callable[[str, bytes], bytes | None]


def rewritten(
    path: Path,
    out: Path,
    change: Change = lambda topic, data: data,
    metadata: dict[str, str] | None = None,
    config: str | None = None,
    *,
    attach: bool = True,
    calibration: str | None = None,
    at_end: bool = False,
) -> Path:
    """A copy, its messages and what stands beside them changed; a message for which `change` gives none is left out.

    With `at_end` metadata and attachments come last, where other programs write them.
    """
    last: list[Metadata | Attachment] = []
    with out.open("wb") as stream:
        writer = Writer(stream, chunk_size=64 * 1024)
        writer.start()
        schemas: dict[int, int] = {}
        channels: dict[int, tuple[int, str]] = {}
        for record in records(path):
            match record:
                case Metadata() | Attachment() if at_end:
                    last.append(record)
                case Metadata():
                    writer.add_metadata(record.name, {**record.metadata, **(metadata or {})})
                case Attachment() if attach:
                    other = {CONFIG: config, CALIBRATION: calibration}.get(record.name)
                    data = record.data if other is None else other.encode()
                    writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, data)
                case Schema():
                    schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
                case Channel():
                    new = writer.register_channel(record.topic, record.message_encoding, schemas[record.schema_id])
                    channels[record.id] = new, record.topic
                case Message():
                    new, topic = channels[record.channel_id]
                    changed = change(topic, record.data)
                    if changed is not None:
                        writer.add_message(new, record.log_time, changed, record.publish_time)
        for one in last:
            if isinstance(one, Metadata):
                writer.add_metadata(one.name, one.metadata)
            else:
                writer.add_attachment(one.create_time, one.log_time, one.name, one.media_type, one.data)
        writer.finish()
    return out


def write_parts(path: Path, folder: Path, at: tuple[int, ...]) -> list[Path]:
    """The log cut in parts at these ticks."""
    bounds = [0, *at, 1_000_000]
    parts = []
    for number, (first, after) in enumerate(pairwise(bounds)):
        parts.append(folder / (f"one-{number:03d}.mcap" if number else "one.mcap"))
        kept = [first == 0]

        def within(
            topic: str, data: bytes, first: int = first, after: int = after, kept: list[bool] = kept
        ) -> bytes | None:
            if topic in (CYCLE.topic, STATE.topic):
                kept[0] = first <= json.loads(data)["tick"] < after
            return data if kept[0] else None

        rewritten(path, parts[-1], within, metadata={"part": str(number)})
    return parts
