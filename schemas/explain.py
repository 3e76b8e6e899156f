"""Validation errors as lines for people: key, value, what is allowed, the nearest valid key."""

import difflib
import json
import types
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

_BOUNDS = (("gt", ">"), ("ge", ">="), ("lt", "<"), ("le", "<="))


def explain(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """One line per error in data for `model`."""
    lines = []
    for item in error.errors(include_url=False):
        path = item["loc"]
        key = _dotted(path)
        if item["type"] == "extra_forbidden":
            owner = _model_at(model, path[:-1])
            names = list(owner.model_fields) if owner else []
            near = difflib.get_close_matches(str(path[-1]), names, n=1)
            hint = f"did you mean '{near[0]}'?" if near else f"known here: {', '.join(names)}"
            lines.append(f"{key}: unknown key; {hint}")
            continue
        message = item["msg"].removeprefix("Value error, ")
        allowed = _allowed(model, path)
        value = _shown(item["input"])
        lines.append(
            (f"{key} = {value}: " if key else "") + message[0].lower() + message[1:]
            + (f" (allowed: {allowed})" if allowed else "")
        )  # fmt: skip
    return lines


def _dotted(path: tuple[int | str, ...]) -> str:
    """control.laws, rod.gravity[2]; names of union branches that pydantic adds are left out."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        elif "[" not in part and part not in {"float", "int", "none"}:
            text += f".{part}" if text else part
    return text


def _shown(value: Any) -> str:
    """A value as TOML would write it, cut short."""
    try:
        text = json.dumps(value)
    except (TypeError, ValueError):
        text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _field_at(model: type[BaseModel], path: tuple[int | str, ...]) -> FieldInfo | None:
    field = None
    current: Any = model
    for part in path:
        if isinstance(part, str) and isinstance(current, type) and issubclass(current, BaseModel):
            field = current.model_fields.get(part)
            if field is None:
                return None
            current = _sections(field.annotation)
    return field


def _sections(annotation: Any) -> Any:
    """The model in an annotation that may also be none, or a list of them; else the annotation."""
    for part in get_args(annotation):
        found = _sections(part)
        if isinstance(found, type) and issubclass(found, BaseModel):
            return found
    return annotation


def _model_at(model: type[BaseModel], path: tuple[int | str, ...]) -> type[BaseModel] | None:
    if not path:
        return model
    field = _field_at(model, path)
    annotation = _sections(field.annotation) if field else None
    return annotation if isinstance(annotation, type) and issubclass(annotation, BaseModel) else None


def _allowed(model: type[BaseModel], path: tuple[int | str, ...]) -> str:
    """The range of the field at `path`, from its constraints."""
    field = _field_at(model, path)
    if field is None:
        return ""
    bounds = bounds_of(field)
    unit = f" {field.description}" if field.description and field.description.startswith("[") else ""
    return f"{bounds}{unit}" if bounds else ""


def bounds_of(field: FieldInfo) -> str:
    """The range of a field's numbers, as in '> 0 and <= 10'; empty where there is none."""
    return _bounds(field.metadata) or _bounds_of_type(field.annotation)


def _bounds(metadata: Any) -> str:
    parts = []
    for item in metadata:
        inner = getattr(item, "metadata", None)
        if inner:
            parts.append(_bounds(inner))
        parts += [f"{sign} {getattr(item, name):g}" for name, sign in _BOUNDS if getattr(item, name, None) is not None]
    return " and ".join(part for part in parts if part)


def _bounds_of_type(annotation: Any) -> str:
    """Bounds of the first constrained part of an annotation."""
    if get_origin(annotation) is Annotated:
        return _bounds(annotation.__metadata__)
    if get_origin(annotation) in {Union, types.UnionType, tuple}:
        for part in get_args(annotation):
            found = _bounds_of_type(part)
            if found:
                return found
    return ""
