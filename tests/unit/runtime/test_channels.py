"""The channels of a log: viewers can read each one's schema."""

import json
from typing import Any

import pytest

from tendond.daemon.recording.channels import CHANNELS


def foxglove_parses(schema: dict[str, Any]) -> bool:
    """The rules of parseJsonSchema in Foxglove Studio and Lichtblick: anything else makes the channel unreadable."""
    match schema.get("type"):
        case "boolean" | "number" | "integer" | "string":
            return True
        case "array":
            return schema["items"].get("type") != "array" and foxglove_parses(schema["items"])
        case "object":
            return all(foxglove_parses(value) for value in schema["properties"].values())
    return False


@pytest.mark.parametrize("channel", CHANNELS, ids=lambda channel: channel.topic)
def test_viewers_can_parse_the_schema_of_every_channel(channel: Any) -> None:
    schema = json.loads(channel.schema())
    assert schema["title"] == channel.schema_name
    assert foxglove_parses(schema)
    assert set(schema["properties"]) == set(channel.model.model_fields)
