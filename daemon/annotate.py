"""A rig.toml with every key of the configuration: what it is, its unit and range, and its default.

`make example` writes deploy/rig.toml so. What is left out by default is commented out, and so are whole sections
that are: the text parses to the defaults.
"""

import textwrap
from collections.abc import Iterator

from tendond.daemon.config_text import comment_of, tables_at, to_toml
from tendond.daemon.laws import LAWS
from tendond.schemas.config import RigConfig
from tendond.schemas.keywords import Key, keys_of, tables

HEADING = """\
# A rig's configuration: every key, what it is, its unit and range, and its default. SI units and radians throughout.
# Keys may be left out, and so may sections; what is commented out is left out. `tendond config check -c rig.toml`
# looks at it, `tendond doctor -c rig.toml` at it and at the rig. An unknown key or a value out of range is refused by
# name before anything starts.
"""


def annotated() -> str:
    """The text of the file."""
    return HEADING + "\n".join(line for table in _every_table() for line in table) + "\n"


def _every_table() -> Iterator[Iterator[str]]:
    data = RigConfig().model_dump(mode="json")
    for table in tables(RigConfig):
        name = table.name.removesuffix("[]")
        each = name != table.name
        off = not tables_at(data, name, each=each)
        yield _table(f"[[{name}]]" if each else f"[{name}]", table.meaning, table.keys, off=off)
        if name == "control":
            for law in LAWS.values():
                yield _table(f"[control.laws.{law.name}]", "", keys_of(law.parameters), off=True)


def _table(header: str, meaning: str, keys: tuple[Key, ...], *, off: bool) -> Iterator[str]:
    hidden = "#" if off else ""
    yield ""
    if meaning:
        yield f"# {meaning[0].upper()}{meaning[1:]}."
    if off:
        yield "# Left out by default: take away the '#' before the heading and before the keys to be set."
    yield f"{hidden}{header}"
    for key in keys:
        if key.name == "laws":
            continue  # tables of their own
        yield from (f"# {line}" for line in textwrap.wrap(comment_of(key), 116))
        yield f"#{key.name} = ..." if key.default is None else f"{hidden}{key.name} = {to_toml(key.default)}"


if __name__ == "__main__":
    print(annotated(), end="")
