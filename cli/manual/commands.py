"""The page of the command line: every command with its help, arguments and options."""

import re
from collections.abc import Iterator
from typing import Any

from typer.main import get_command

from tendond.cli.app import app
from tendond.cli.manual.markdown import code, escaped, table
from tendond.cli.program import EVERYDAY, MOVED

_HEAD = """\
# Command line

Run `tendond COMMAND --help` for the same text. File names are relative to the current directory; those in a
configuration are relative to the configuration's folder.

{everyday}

## Exit status

| status | meaning |
| --- | --- |
| 0 | success; `run`, `simulate`, `mocap`, `servo`: stopped by Ctrl-C or SIGTERM, tendons released |
| 1 | refused or failed, with a message: no controller, arming refused, a replay that differs, an incomplete log |
| 2 | invalid usage, configuration or log |
| 130 | interrupted by Ctrl-C |

Results go to standard output; progress, notes and errors to standard error, each line prefixed with `tendond: `.
Without a terminal there are no colours and no progress bar; `NO_COLOR` is honoured. `--json` prints the result as JSON
and nothing else. Closed pipes are ignored, as in `tendond config show | head`; the exit status is then 1.

## Old spellings

They still run, and print the new one on standard error.

{moved}

## Completion

`tendond --install-completion` completes commands, options, laws, profiles and faults in bash, zsh, fish and PowerShell.
"""


def commands_page() -> str:
    """Write the page: a section for each command, under its group."""
    short = ", ".join(f"`tendond {name}`" for name in EVERYDAY)
    everyday = f"The everyday commands need no group: {short}."
    rows = [(code(f"tendond {old}"), code(f"tendond {moved.now}")) for old, moved in MOVED.items()]
    rows.append((code("tendond replay --law, --set, --closed-loop"), code("tendond log what-if")))
    head = _HEAD.format(everyday=everyday, moved=table(("old", "new"), rows))
    return "\n".join([head, *_sections(get_command(app), ())])


def _sections(command: Any, name: tuple[str, ...]) -> Iterator[str]:
    if name:
        yield _section(command, " ".join(("tendond", *name)), level=min(len(name) + 1, 3))
    for word, inner in getattr(command, "commands", {}).items():
        if inner.hidden or (not name and word in EVERYDAY):
            continue
        yield from _sections(inner, (*name, word))


def _section(command: Any, name: str, level: int) -> str:
    context = command.context_class(command)
    usage = " ".join([name, *command.collect_usage_pieces(context)])
    parts = [f"{'#' * level} {name}\n", *_help(command.help or ""), f"```text\n{usage}\n```\n"]
    for kind in ("argument", "option"):
        records = [
            one.get_help_record(context)
            for one in command.params
            if one.param_type_name == kind and not one.hidden and one.name != "help"
        ]
        if rows := [(_names(names), escaped(text)) for names, text in records]:
            parts.append(table((kind, "meaning"), rows) + "\n")
    return "\n".join(parts)


def _names(text: str) -> str:
    """Format '-c, --config <path>' as `--config`, `-c` FILE."""
    names, _, kind = text.partition(" <")
    shown = ", ".join(code(name) for name in re.split(r",\s+|\s+/\s+", names))
    return f"{shown} {kind.rstrip('>')}" if kind else shown


def _help(text: str) -> Iterator[str]:
    for paragraph in text.strip().split("\n\n"):
        line = " ".join(paragraph.split())
        if match := re.match(r"(Examples?(?:, [^:]*)?): (.*)", line):
            yield f"{match[1]}:\n"
            commands = [_command(part) for part in match[2].split("; ")]
            yield "```sh\n" + "\n".join(commands) + "\n```\n"
        else:
            yield escaped(line) + "\n"


def _command(text: str) -> str:
    """Turn an example into a line of shell; words around the command become a comment."""
    start = text.find("tendond ")
    before, rest = text[:start].strip(" ,"), text[start:]
    command, comma, after = rest.partition(", ")
    if not comma or "tendond" in after:
        command, after = rest, ""
    remark = ", ".join(part for part in (before, after) if part)
    return f"{command}  # {remark}" if remark else command
