"""Base class of all data that cross a boundary: frozen, finite, without unknown fields."""

from collections.abc import Sized
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict, Field

SCHEMA_VERSION: Literal[1] = 1

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""Unit quaternion w, x, y, z; body to world."""

PerTendon = Annotated[tuple[float, ...], Field(min_length=1, max_length=16)]
"""One number per tendon, in the order of the rig's configuration."""

PerTendonOrNone = Annotated[tuple[float, ...], Field(max_length=16)]
"""The same, or empty where there are none."""


def is_empty(value: Sized) -> bool:
    """Return whether an optional field is left out of a message: `Field((), exclude_if=is_empty)`."""
    return len(value) == 0


class Schema(BaseModel):
    """Frozen, strict about unknown keys, and without NaN or infinity."""

    REQUIRED: ClassVar[frozenset[str]] = frozenset()
    """Fields that a payload must have, although they have defaults in Python."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, ser_json_inf_nan="constants")

    @classmethod
    def trusted(cls, **values: Any) -> Self:
        """Build a message without validation, from all fields in their order.

        Faster than `model_construct`, which looks each field up.
        """
        message = cls.__new__(cls)
        object.__setattr__(message, "__dict__", values)
        object.__setattr__(message, "__pydantic_fields_set__", set(values))
        object.__setattr__(message, "__pydantic_extra__", None)
        object.__setattr__(message, "__pydantic_private__", None)
        return message
