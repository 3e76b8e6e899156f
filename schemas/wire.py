"""Messages to bytes and back: bounded and validated; every refusal has one of a few reasons."""

from typing import TypeVar

from pydantic import ValidationError

from tendond.schemas.base import Schema
from tendond.schemas.messages import LARGEST_PAYLOAD

S = TypeVar("S", bound=Schema)

DETAIL_LENGTH = 80
"""Largest number of characters of a field's name, or of its error, in a refusal."""

_REASONS = {"finite_number": "not finite", "json_invalid": "malformed"}


class UnreadableError(Exception):
    """A payload is not a message of the expected kind.

    Attributes:
        reason: one of a few short phrases, for counting.
        detail: field and error, for people; may be empty.
    """

    def __init__(self, reason: str, detail: str = "") -> None:
        self.reason = reason
        self.detail = detail
        super().__init__(reason)


def encode(message: Schema) -> bytes:
    """Return the message as JSON in UTF-8."""
    return message.__pydantic_serializer__.to_json(message)  # model_dump_json without the text in between


def decode(kind: type[S], payload: bytes) -> S:
    """Return the message in a payload.

    Raises:
        UnreadableError: too large, not JSON, not finite, another version, or another kind.
    """
    if len(payload) > LARGEST_PAYLOAD:
        raise UnreadableError("too large")
    try:
        message: S = kind.__pydantic_validator__.validate_json(payload, strict=True)
    except ValidationError as error:
        first = error.errors(include_url=False, include_context=False, include_input=False)[0]
        detail = _detail(kind, first["loc"], first["msg"])
        if first["loc"][:1] == ("version",):
            raise UnreadableError("wrong version", detail) from None
        if first["loc"][:1] == ("orientation",) and first["type"] == "value_error":
            raise UnreadableError("bad quaternion", detail) from None
        raise UnreadableError(_REASONS.get(first["type"], "malformed"), detail) from None
    if not message.__pydantic_fields_set__ >= kind.REQUIRED:
        missing = sorted(kind.REQUIRED - message.__pydantic_fields_set__)[0]
        raise UnreadableError("malformed", _detail(kind, (missing,), "is missing"))
    return message


def _detail(kind: type[Schema], place: tuple[int | str, ...], text: str) -> str:
    """Return one bounded line that names the field: keys of foreign messages may be long."""
    where = ".".join(str(part) for part in place)[:DETAIL_LENGTH]
    return f"{kind.__name__}{'.' if where else ''}{where}: {text[:DETAIL_LENGTH]}"
