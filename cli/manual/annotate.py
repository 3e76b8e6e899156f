"""A rig.toml with every key of the configuration: what it is, its unit and range, and its default.

`make example` writes deploy/rig.toml so. What is not set by default is commented out, and so are whole sections
that are: the text parses to the defaults.
"""

import textwrap
from collections.abc import Iterator

from tendond.cli.manual.config_text import OPTIONAL, VERSION_MEANING, comment_of, to_toml
from tendond.daemon.control.laws import LAWS
from tendond.schemas.config.migration.version import CONFIG_VERSION, KEY
from tendond.schemas.config.rates import DERIVED
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.errors.keywords import Table, keys_of, tables

HEADING = """\
# A rig's configuration: every key, what it is, its unit and range, and its default. SI units and radians throughout.
# Keys and sections are optional; what is commented out is not set. `tendond config check rig.toml` looks at
# it, `tendond doctor -c rig.toml` at the rig as well. An unknown key or a value out of range is refused by name before
# anything starts.
"""
WIDTH = 116
INHERITED = ("simulator.rod",)
"""Tables whose keys have the values of another one by default."""


def annotated() -> str:
    """Write the text of the example."""
    return HEADING + _version() + "".join(f"{line}\n" for table in tables(RigConfig) for line in _section(table))


def _version() -> str:
    return f"\n# a whole number >= 1 and <= {CONFIG_VERSION}; {VERSION_MEANING}\n{KEY} = {CONFIG_VERSION}\n"


def _section(table: Table) -> Iterator[str]:
    """Yield a heading and its keys; the tables of the laws' parameters after [control]."""
    name = table.name.removesuffix("[]")
    each = name != table.name
    off = table.optional or name.partition(".")[0] in OPTIONAL or name in INHERITED
    yield from _heading(f"[[{name}]]" if each else f"[{name}]", table.meaning, off)
    laws = False
    for key in table.keys:
        if isinstance(key.default, dict):
            laws = True
            continue
        yield from _comment(comment_of(key))
        if key.required or key.default is None:
            yield f"#{key.name} = ..."
        else:
            yield f"{'#' if off or key.path in DERIVED else ''}{key.name} = {to_toml(key.default)}"
    for law in LAWS.values() if laws else ():
        yield from _heading(f"[{name}.laws.{law.name}]", " ".join((law.parameters.__doc__ or "").split()), off=True)
        for key in keys_of(law.parameters):
            yield from _comment(comment_of(key))
            yield f"#{key.name} = {to_toml(key.default)}"


def _heading(text: str, meaning: str, off: bool) -> Iterator[str]:
    yield ""
    yield from _comment(meaning)
    if off:
        yield "# Optional: remove the '#' before the heading and before the keys to be set."
    yield f"{'#' if off else ''}{text}"


def _comment(text: str) -> Iterator[str]:
    yield from (f"# {line}" for line in textwrap.wrap(text, WIDTH))


if __name__ == "__main__":
    print(annotated(), end="")
