"""Keys that may change while the controller runs, declared where their section has the field.

The mark is part of the field's JSON Schema: `Field(..., json_schema_extra=tunable(0.5))`.
"""

from typing import Any, NamedTuple

from pydantic import JsonValue

from tendond.schemas.errors.keywords import schema_of

MARK = "x-tunable"


class Mark(NamedTuple):
    """A tunable key.

    Attributes:
        rate: largest relative rate of change while armed [1/s]; none: it changes only while idle.
        lower_only: no value above the configuration's is accepted.
    """

    rate: float | None
    lower_only: bool


def tunable(rate: float, *, lower_only: bool = False) -> dict[str, JsonValue]:
    """Mark a positive number that may change while armed, in the `json_schema_extra` of its field.

    Args:
        rate: largest relative rate of change [1/s]: in a cycle of h seconds by a factor of 1 + rate h.
        lower_only: refuse values above the configuration's, of what others have checked or planned with.
    """
    return {MARK: {"rate": rate, "lower_only": lower_only}}


def tunable_while_idle(*, lower_only: bool = False) -> dict[str, JsonValue]:
    """Mark a number that may change while the rig is idle only; `lower_only` as for `tunable`."""
    return {MARK: {"rate": None, "lower_only": lower_only}}


def marks_of(model: Any) -> dict[str, Mark]:
    """Return the marks of a section, or of a law's parameters, by name of the field."""
    properties = schema_of(model).get("properties", {})
    return {name: Mark(**node[MARK]) for name, node in properties.items() if MARK in node}
