"""The top level of the command line: groups by noun, their everyday commands, and old spellings that still run."""

import copy
import functools
import sys
from collections.abc import Callable, Mapping, MutableMapping
from dataclasses import dataclass, field
from typing import Any

from typer.core import TyperGroup

Commands = MutableMapping[str, Any]

EVERYDAY = {
    "run": "rig",
    "simulate": "rig",
    "arm": "rig",
    "stop": "rig",
    "reset": "rig",
    "status": "rig",
    "watch": "rig",
    "dashboard": "rig",
    "teleop": "rig",
    "set": "rig",
    "doctor": "rig",
    "replay": "log",
    "plot": "log",
    "animate": "log",
    "identify": "study",
}
"""Commands that are at the top level as well, and the group that each belongs to."""


@dataclass(frozen=True)
class Alias:
    """A command that has a new name; `values` are the options that the new spelling spells out."""

    now: str
    values: Mapping[str, object] = field(default_factory=dict)


MOVED = {
    "vicon": Alias("rig vicon"),
    "inject": Alias("rig inject"),
    "law": Alias("rig law"),
    "reference": Alias("rig reference"),
    "compare": Alias("log compare"),
    "report": Alias("log report"),
    "view": Alias("log view"),
    "paper": Alias("study paper"),
    "robustness": Alias("study robustness"),
    "rig-demo": Alias("demo --scenario wired", {"scenario": "wired"}),
    "demo-3d": Alias("demo --scenario spatial", {"scenario": "spatial"}),
}
"""Old spellings at the top level."""


class Program(TyperGroup):
    """The root group; typer fills in the groups, the tables above the rest."""

    def __init__(self, **attributes: Any) -> None:
        super().__init__(**attributes)
        groups = dict(self.commands)
        for name, group in EVERYDAY.items():
            self.commands[name] = _found(groups, f"{group} {name}")
        for old, moved in MOVED.items():
            self.commands[old] = _renamed(_found(groups, moved.now), old, moved)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the groups, then the everyday commands; old spellings are hidden."""
        shown = {name: command for name, command in self.commands.items() if not command.hidden}
        groups = {name: one for name, one in shown.items() if hasattr(one, "commands") and name not in EVERYDAY}
        everyday = {name: command for name, command in shown.items() if name not in groups}
        limit = formatter.width - 6 - max(map(len, shown))
        for title, commands in (("Command groups", groups), ("Everyday commands", everyday)):
            with formatter.section(title):
                formatter.write_dl([(name, one.get_short_help_str(limit)) for name, one in commands.items()])


def say_renamed(old: str, new: str) -> None:
    """Print the line that names the new spelling."""
    print(f"tendond: 'tendond {old}' is now 'tendond {new}'", file=sys.stderr, flush=True)


def _found(commands: Commands, words: str) -> Any:
    """Find the command with these words, without the options among them."""
    found: Any = None
    for word in words.split(" --")[0].split():
        found = commands[word]
        commands = getattr(found, "commands", {})
    return found


def _renamed(command: Any, old: str, moved: Alias) -> Any:
    """Return a hidden copy of a command that prints its new spelling before it runs."""
    run: Callable[..., Any] = command.callback

    @functools.wraps(run)
    def with_notice(*positional: Any, **values: Any) -> Any:
        say_renamed(old, moved.now)
        return run(*positional, **{**values, **moved.values})

    renamed = copy.copy(command)
    renamed.name, renamed.hidden, renamed.callback = old, True, with_notice
    return renamed
