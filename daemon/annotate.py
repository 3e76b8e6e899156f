"""A rig.toml with every key of the configuration: what it is, its unit and range, and its default.

`make example` writes deploy/rig.toml so. What is left out by default is commented out, and so are whole sections
that are: the text parses to the defaults.
"""

import json
import textwrap
from collections.abc import Iterator
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from tendond.daemon.laws import LAWS
from tendond.schemas.config import RigConfig
from tendond.schemas.explain import bounds_of

HEADING = """\
# A rig's configuration: every key, what it is, its unit and range, and its default. SI units and radians throughout.
# Keys may be left out, and so may sections; what is commented out is left out. `tendond doctor -c rig.toml` looks at
# it and at the rig. An unknown key or a value out of range is refused by name before anything starts.
"""


def annotated() -> str:
    """The text of the file."""
    return HEADING + "\n".join(line for name in RigConfig.model_fields for line in _section(name)) + "\n"


def _section(name: str) -> Iterator[str]:
    field = RigConfig.model_fields[name]
    model = _model_in(field.annotation)
    assert model is not None
    yield from _table(model, name, off=field.default is None)


def _table(model: type[BaseModel], path: str, *, off: bool, many: bool = False) -> Iterator[str]:
    """A section: its heading, its keys, then the sections in it."""
    hidden = "#" if off else ""
    doc = (model.__doc__ or "").split("\n")[0]
    about = doc.partition("]: ")[2] if doc.startswith("[") else doc
    yield ""
    if about:
        yield f"# {about[0].upper()}{about[1:]}"
    if off:
        yield "# Left out by default: take away the '#' before the heading and before the keys to be set."
    yield f"{hidden}[[{path}]]" if many else f"{hidden}[{path}]"
    nested = []
    for key, field in model.model_fields.items():
        inner = _model_in(field.annotation)
        if inner is not None:
            nested.append(_table(inner, f"{path}.{key}", off=off or not field.default, many=not _is_model(field)))
        elif path == "control" and key == "laws":
            nested += [_table(law.parameters, f"control.laws.{name}", off=True) for name, law in LAWS.items()]
        else:
            yield from _entry(key, field, hidden)
    for table in nested:
        yield from table


def _entry(key: str, field: FieldInfo, hidden: str) -> Iterator[str]:
    remark = "; ".join(filter(None, (_description(field), _allowed(field))))
    yield from (f"# {line}" for line in textwrap.wrap(remark, 116))
    if field.is_required() or field.default is None:
        yield f"#{key} = ..."
    else:
        yield f"{hidden}{key} = {_toml(field.default)}"


def _allowed(field: FieldInfo) -> str:
    """The range, or the choices."""
    if get_origin(field.annotation) is Literal:
        return "one of " + ", ".join(_toml(choice) for choice in get_args(field.annotation))
    return bounds_of(field)


def _description(field: FieldInfo) -> str:
    """Of the field, or of the type in it that may be left out."""
    found: str | None = field.description
    for part in () if found else get_args(field.annotation):
        for item in getattr(part, "__metadata__", ()):
            found = found or getattr(item, "description", None)
    return found or ""


def _toml(value: Any) -> str:
    """As TOML writes it."""
    if isinstance(value, tuple):
        return f"[{', '.join(_toml(one) for one in value)}]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def _is_model(field: FieldInfo) -> bool:
    return isinstance(field.default, BaseModel)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """The section in an annotation, which may also be none, or a list of them."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := _model_in(part)) is not None), None)


if __name__ == "__main__":
    print(annotated(), end="")
