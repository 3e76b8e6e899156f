"""The state between two cycles as text and back, to the last bit: from it a log is replayed from the middle.

The types of the fields say how a text is read, so a field that is added to the state needs no line here. What holds
functions (a law, a reference) says itself what of it is data and is made again from that: `Rebuilt`.
"""

import base64
import dataclasses
import types
from collections.abc import Callable, Sized
from enum import Enum
from functools import cache
from typing import (
    Annotated,
    Any,
    Literal,
    Protocol,
    Self,
    TypeVar,
    Union,
    get_args,
    get_origin,
    get_type_hints,
)

import numpy as np
from pydantic import BaseModel, PlainSerializer
from pydantic_core import from_json, to_json

from tendond.daemon.control.renamed import with_present_names
from tendond.schemas.base import Schema

T = TypeVar("T")

SNAPSHOT_VERSION: Literal[2] = 2
"""Version 1 had other names of the state's fields: see `renamed`."""


LEFT_OUT_IF_EMPTY = {"left_out_if_empty": True}
"""Metadata of a dataclass's field, with a default, whose empty container, or none, is left out of the text."""


class Rebuilt(Protocol):
    """A part of the state that is more than data."""

    def to_snapshot(self) -> Any:
        """Return the data of it, as JSON has it."""

    @classmethod
    def from_snapshot(cls, data: Any, setup: Any) -> Self:
        """The part again; `setup` is the cycle's."""


class StateSnapshot(Schema):
    """State of the controller before a cycle.

    Attributes:
        version: version of the schema.
        tick: index of the cycle that follows.
        left_out: cycles before it that were left out of the log on purpose, while the arm was idle.
        state: see `encode_state`; a function that gives it is called when the message is written, in the recorder.
    """

    version: Literal[1, 2] = SNAPSHOT_VERSION
    tick: int
    left_out: int = 0
    state: Annotated[
        str | Callable[[], str], PlainSerializer(lambda value: value() if callable(value) else value, return_type=str)
    ]


def encode_state(state: Any) -> str:
    """A dataclass of numbers, texts, arrays, messages and other such dataclasses as JSON; arrays as base64."""
    return to_json(to_plain(state), inf_nan_mode="constants").decode()  # a quarter of the time of json's own


def decode_state(kind: type[T], text: str, setup: Any = None) -> T:
    """The dataclass that `encode_state` wrote; `setup` is the cycle's, for what is `Rebuilt`.

    Raises:
        ValueError: the text is of another class, or of another version of it.
    """
    try:
        value = from_plain(kind, from_json(text), setup)
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ValueError(
            f"is no {kind.__name__} of this version of tendond ({type(error).__name__}: {error})"
        ) from error
    assert isinstance(value, kind)
    return value


def to_plain(value: Any) -> Any:
    """Return a value as JSON has it: arrays as base64, dataclasses as objects."""
    if isinstance(value, np.ndarray):
        data = base64.b64encode(np.ascontiguousarray(value).tobytes()).decode()
        return {"dtype": value.dtype.str, "shape": list(value.shape), "data": data}
    if isinstance(value, np.generic):
        return value.item()
    if hasattr(value, "to_snapshot"):
        return value.to_snapshot()
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if dataclasses.is_dataclass(value):
        kept = {
            field.name: getattr(value, field.name)
            for field in dataclasses.fields(value)
            if not field.metadata or not _is_left_out(getattr(value, field.name))
        }
        return {name: to_plain(one) for name, one in kept.items()}
    if isinstance(value, Enum):
        return value.value
    if isinstance(value, dict):
        return {key: to_plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain(item) for item in value]
    return value


def _is_left_out(value: Any) -> bool:
    return value is None or (isinstance(value, Sized) and len(value) == 0)


def from_plain(kind: Any, value: Any, setup: Any) -> Any:
    """Return the value of type `kind` that `to_plain` wrote; `setup` is the cycle's, for what is `Rebuilt`."""
    origin = get_origin(kind)
    if origin is Annotated:
        return from_plain(get_args(kind)[0], value, setup)
    if origin in (Union, types.UnionType):
        if value is None:
            return None
        classes = [option for option in get_args(kind) if option is not type(None)]
        return from_plain(_described(classes, value), value, setup)
    if origin is np.ndarray or kind is np.ndarray:
        data = np.frombuffer(base64.b64decode(value["data"]), np.dtype(value["dtype"]))
        return data.reshape(value["shape"]).copy()
    if origin is dict:
        item = get_args(kind)[1]
        return {key: from_plain(item, one, setup) for key, one in value.items()}
    if origin is tuple:
        options = get_args(kind)
        items = options[:1] * len(value) if options[-1] is Ellipsis else options
        return tuple(from_plain(item, one, setup) for item, one in zip(items, value, strict=True))
    if origin is list:
        return [from_plain(get_args(kind)[0], one, setup) for one in value]
    if hasattr(kind, "from_snapshot"):
        return kind.from_snapshot(value, setup)
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind.model_validate(value)
    if dataclasses.is_dataclass(kind):
        return _dataclass(kind, value, setup)
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind(value)
    return value


def _described(classes: list[Any], value: Any) -> Any:
    """The class of several whose fields a text has; the first one where none has them all."""
    return next((one for one in classes[1:] if _hints(one).keys() == value.keys()), classes[0])


def _dataclass(kind: Any, value: dict[str, Any], setup: Any) -> Any:
    hints = _hints(kind)
    if hints.keys() != value.keys():
        value = with_present_names(kind.__name__, value)
    missing = hints.keys() - value.keys()
    unknown = (value.keys() - hints.keys()) | {name for name in missing if not _has_default(kind, name)}
    if unknown:
        raise KeyError(f"{kind.__name__}: {', '.join(sorted(unknown))}")
    return kind(**{name: from_plain(hint, value[name], setup) for name, hint in hints.items() if name not in missing})


@cache
def _has_default(kind: Any, name: str) -> bool:
    """True if a field may be missing: it was added to the state after the snapshot was written."""
    (field,) = (one for one in dataclasses.fields(kind) if one.name == name)
    return field.default is not dataclasses.MISSING or field.default_factory is not dataclasses.MISSING


@cache
def _hints(kind: Any) -> dict[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {field.name: hints[field.name] for field in dataclasses.fields(kind)}
