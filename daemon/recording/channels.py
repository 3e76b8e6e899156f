"""The channels of a log: topic, message type, and the type's JSON Schema as viewers take it."""

import json
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from pydantic import BaseModel

from tendond.daemon.control.snapshot import StateSnapshot
from tendond.daemon.recording import foxglove
from tendond.daemon.recording.entities import SceneUpdate
from tendond.schemas.messages import SimulatorTruth, Status
from tendond.schemas.record import CycleRecord, LoopTiming

M = TypeVar("M", bound=BaseModel)


@dataclass(frozen=True)
class Channel(Generic[M]):
    """A topic in the log and the one type of message on it."""

    topic: str
    model: type[M]

    @property
    def schema_name(self) -> str:
        """Name by which viewers know what to draw: `foxglove.Log`, `tendond.CycleRecord`."""
        namespace = "foxglove" if issubclass(self.model, foxglove.WellKnown) else "tendond"
        return f"{namespace}.{self.model.__name__}"

    def schema(self) -> bytes:
        """JSON Schema of the messages."""
        return json.dumps(json_schema(self.model, self.schema_name)).encode()


CYCLE = Channel("cycle", CycleRecord)
TIMING = Channel("timing", LoopTiming)
STATUS = Channel("status", Status)
TIP_MEASURED = Channel("tip/measured", foxglove.PoseInFrame)
TIP_MODEL = Channel("tip/model", foxglove.PoseInFrame)
ROD_SHAPE = Channel("rod/shape", SceneUpdate)
LOG = Channel("log", foxglove.Log)
TRUTH = Channel("truth", SimulatorTruth)
STATE = Channel("state", StateSnapshot)
TRANSFORMS = Channel("tf", foxglove.FrameTransforms)

CHANNELS: tuple[Channel[Any], ...] = (
    CYCLE,
    TIMING,
    STATUS,
    TIP_MEASURED,
    TIP_MODEL,
    ROD_SHAPE,
    LOG,
    TRUTH,
    STATE,
    TRANSFORMS,
)


BEGINNING = next((channel for channel in CHANNELS if channel.topic == "state"), CYCLE)
"""First message in each file of a split run: never half of a cycle, and a state where there is one."""


def json_schema(model: type[BaseModel], title: str) -> dict[str, Any]:
    """The JSON Schema of what `model` serialises to, as Foxglove's and Lichtblick's parsers take it.

    They refuse a channel whose schema has `$ref`, `anyOf`, an array without `items` or an object without `properties`,
    and pydantic writes all four. So references are put in place, a tuple becomes an array of its first item's type, and
    `X | None` becomes X: a null is the one thing in which a message may depart from its schema.
    """
    schema = model.model_json_schema(mode="serialization")
    return {**_simple(schema, schema.get("$defs", {})), "title": title}


def _simple(schema: dict[str, Any], definitions: dict[str, Any]) -> dict[str, Any]:
    """One level of a schema in that dialect, and all below it."""
    if "$ref" in schema:
        target = definitions[schema["$ref"].removeprefix("#/$defs/")]
        return _simple({**target, **_without(schema, "$ref")}, definitions)
    if "anyOf" in schema:
        option = next(option for option in schema["anyOf"] if option.get("type") != "null")
        return _simple({**_without(schema, "anyOf"), **option}, definitions)
    simple = _without(schema, "$defs", "prefixItems", "default")
    if schema.get("type") == "array":
        items = _simple(schema["prefixItems"][0] if "prefixItems" in schema else schema["items"], definitions)
        # An array of arrays they refuse as well: samples of a reference pass for objects, and are shown as they are.
        simple["items"] = {"type": "object", "properties": {}} if items.get("type") == "array" else items
    if schema.get("type") == "object":
        properties = schema.get("properties", {})
        simple["properties"] = {key: _simple(value, definitions) for key, value in properties.items()}
        if isinstance(schema.get("additionalProperties"), dict):
            simple["additionalProperties"] = True  # a mapping: a law's terms may be numbers or vectors
    return simple


def _without(schema: dict[str, Any], *keys: str) -> dict[str, Any]:
    return {key: value for key, value in schema.items() if key not in keys}
