"""The pages of the keys on the bus, of the messages, and of what a log has."""

import re
from collections.abc import Iterator

from tendond.cli.manual.markdown import attributes, code, escaped, summary, table
from tendond.daemon.recording.channels import CHANNELS
from tendond.offline.logs.units import unit_of
from tendond.schemas import health, messages, record, requests
from tendond.schemas.base import SCHEMA_VERSION, Schema
from tendond.schemas.errors.keywords import in_words, resolved, schema_of
from tendond.schemas.faults import FAULTS, FaultRequest
from tendond.schemas.messages import ENCODING, LARGEST_PAYLOAD, Message
from tendond.schemas.topics import TOPICS

EXAMPLES: dict[type[Schema], Schema] = {
    messages.TipPose: messages.TipPose(
        seq=4711, stamp_ns=81_234_567_890, position=(0.3401, 0.0002, 0.0474), orientation=(0.55, 0.0, 0.8352, 0.0)
    ),
    messages.TendonCommand: messages.TendonCommand(
        seq=4712, stamp_ns=81_234_901_234, pose_seq=4711, displacement=(0.0576, 0.0, -0.0575, 0.0),
        tension=(43.09, 0.0, 0.0, 0.0), armed=True,
    ),
    messages.TendonState: messages.TendonState(
        seq=4709, stamp_ns=81_234_456_789, displacement=(0.0575, 0.0, -0.0575, 0.0), tension=(43.0, 0.0, 0.0, 0.0)
    ),
    requests.ControlReply: requests.ControlReply(done=False, message="no pose yet: is the camera's driver running?"),
}  # fmt: skip


def keys_page() -> str:
    """Write the page of all keys, in Markdown."""
    rows: dict[str, list[tuple[str, ...]]] = {"published": [], "request": [], "token": []}
    for topic in TOPICS:
        links = [_link(kind) for kind in (topic.message, topic.reply)]
        used = {"published": links[:1], "request": links, "token": []}[topic.kind]
        rows[topic.kind].append((code(f"<rig>/{topic.name}"), *used, topic.by, topic.to, topic.meaning))
    published = table(("key", "message", "by", "to", "what it is"), rows["published"])
    requests = table(("key", "request", "reply", "by", "to", "what it is"), rows["request"])
    tokens = table(("liveliness token", "by", "to", "what it is"), rows["token"])
    return f"""\
# Zenoh keys

Every key starts with the rig's name, `rig.name` of the configuration: `paper/tip/pose`. The controller is the hub, a
Zenoh peer that listens on `bus.endpoint`; all others are clients of it. Processes are named by their commands.
Who may do what can be restricted by key: [securing the bus](../howto/secure-bus.md).

## Published

{published}

## Requests

Queries with a reply.

{requests}

## Tokens

{tokens}
"""


def messages_page() -> str:
    """Write the page of all messages with fields and an example, in Markdown."""
    kinds: list[type[Schema]] = []
    for topic in TOPICS:
        kinds += [kind for kind in (topic.message, topic.reply) if kind is not None and kind not in kinds]
    parts = [
        f"""\
# Messages

JSON in UTF-8, with the Zenoh encoding `{ENCODING}`; SI units, radians, double precision. A payload is refused,
and counted by its reason, if it is larger than {LARGEST_PAYLOAD} bytes, is not JSON, has an unknown field,
lacks one, has a number that is not finite, or another `version` than {SCHEMA_VERSION}. Those that are published
repeatedly have a sequence number `seq` and a capture time `stamp_ns`; the receiver takes their age on its own clock.
"""
    ]
    kinds += [health.LoopHealth, health.SensorHealth]
    for kind in kinds:
        example = EXAMPLES.get(kind)
        parts.append(f"## {kind.__name__}\n\n{escaped(summary(kind))}\n\n{_fields(kind)}\n")
        if example is not None:
            text = re.sub(r"\[[^]]*\]", lambda found: " ".join(found[0].split()), example.model_dump_json(indent=2))
            parts.append(f"```json\n{text}\n```\n")
        if kind is FaultRequest:
            parts.append(_faults())
    modes = ", ".join(code(mode.value) for mode in messages.Mode)
    parts.append(f"## Mode\n\n{escaped(summary(messages.Mode))} One of {modes}.\n")
    parts.append("[How they follow each other](../explanation/faults.md#modes).\n")
    return "\n".join(parts)


def log_page() -> str:
    """Write the page of a log's channels and of the fields of the cycle's record, in Markdown."""
    channels = table(
        ("topic", "schema", "of"),
        [
            (code(channel.topic), code(channel.schema_name), _first_sentence(summary(channel.model)))
            for channel in CHANNELS
        ],
    )
    parts = [
        f"""\
# What is in a log

An MCAP file has these channels, each with its JSON Schema, so that any MCAP tool reads it. The configuration is
attached; versions, processor and times are in the metadata. Foxglove's own types are drawn by viewers as they are.

{channels}

In Python `tendond.offline.logs.load` gives the fields of `cycle` as arrays, by the names below with dots between
(`command.displacement`), with units; [how](../howto/notebook.md).
"""
    ]
    kinds = (record.CycleRecord, record.CycleInputs, record.ReferencePoint, record.ObserverEstimate, record.TipEstimate,
             record.ModelState, record.LoopTiming)  # fmt: skip
    for kind in kinds:
        parts.append(f"## {kind.__name__}\n\n{escaped(summary(kind))}\n\n{_fields(kind, units=True)}\n")
    return "\n".join(parts)


def _fields(kind: type[Schema], *, units: bool = False) -> str:
    """Return the fields of a message: its own, then those of all messages."""
    schema = schema_of(kind)
    said = attributes(kind, schema["properties"])
    if issubclass(kind, Message):
        said = {**attributes(Message), **said}
    rows = []
    for name, node in schema["properties"].items():
        inner = resolved(schema, node)
        words = in_words(schema, node)
        if "title" in inner and "properties" in inner:
            words = f"{'list of ' if inner is not node and 'items' in node else ''}{inner['title']}"
        if any(branch.get("type") == "null" for branch in node.get("anyOf", ())):
            words += ", or null"
        cells = (code(name), escaped(words), escaped(said.get(name, "")))
        rows.append((*cells[:2], unit_of(name), cells[2]) if units else cells)
    return table(("field", "is", "unit", "meaning") if units else ("field", "is", "meaning"), rows)


def _faults() -> str:
    rows = [
        (
            code(fault.value),
            kind.meaning,
            "" if kind.seconds is None else f"{kind.seconds:g} s",
            "" if kind.size is None else f"{kind.size:g} {kind.unit}, max. {kind.size_max:g}",
            ", ".join(_takes(kind.directed, kind.servo, kind.wires)),
        )
        for fault, kind in FAULTS.items()
    ]
    return table(("fault", "what happens", "lasts", "size", "takes"), rows) + "\n"


def _takes(directed: bool, servo: bool, wires: bool) -> Iterator[str]:
    if directed:
        yield "direction"
    if servo:
        yield "servo"
    if wires:
        yield "only with --wired"


def _link(kind: type[Schema] | None) -> str:
    return "" if kind is None else f"[{kind.__name__}](messages.md#{kind.__name__.lower()})"


def _first_sentence(text: str) -> str:
    return escaped(text.split(". ")[0].rstrip("."))
