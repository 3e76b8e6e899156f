"""Messages to bytes and back: bounded, validated, and every refusal named by one of a few reasons."""

from typing import TypeVar

from pydantic import ValidationError

from tendond.schemas.base import Schema
from tendond.schemas.messages import LARGEST_PAYLOAD

S = TypeVar("S", bound=Schema)

_REASONS = {"finite_number": "not finite", "json_invalid": "malformed"}


class UnreadableError(Exception):
    """A payload that is no message of the wanted kind; `reason` is one of a few short phrases, for counting."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


def encode(message: Schema) -> bytes:
    """JSON, UTF-8."""
    return message.__pydantic_serializer__.to_json(message)  # model_dump_json without the text in between


def decode(kind: type[S], payload: bytes) -> S:
    """The message in a payload.

    Raises:
        UnreadableError: too large, no JSON, not finite, another version, or not of this kind.
    """
    if len(payload) > LARGEST_PAYLOAD:
        raise UnreadableError("too large")
    try:
        message: S = kind.__pydantic_validator__.validate_json(payload, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        if first["loc"][:1] == ("version",):
            raise UnreadableError("wrong version") from None
        if first["loc"][:1] == ("orientation",) and first["type"] == "value_error":
            raise UnreadableError("bad quaternion") from None
        raise UnreadableError(_REASONS.get(first["type"], "malformed")) from None
    return message
