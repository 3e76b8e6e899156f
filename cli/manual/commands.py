"""The page of the command line: every command with its help, arguments and options."""

import re
from collections.abc import Iterator
from typing import Any

from typer.main import get_command

from tendond.cli.app import app
from tendond.cli.manual.markdown import code, escaped, table

_HEAD = """\
# Command line

`tendond COMMAND --help` says the same as this page. Names of files are given relative to where one is; a file that a
configuration names is found beside the configuration.

## Exit status

| status | meaning |
| --- | --- |
| 0 | done; of `run`, `simulate`, `vicon`, `servo`: ended by Ctrl-C or SIGTERM, the tendons let go |
| 1 | refused or failed, and said in a line: no controller, arming refused, a replay that differs, a log not whole |
| 2 | wrong usage, a configuration or a log that cannot be used |
| 130 | interrupted by Ctrl-C before it was done |

Results go to standard output; progress, notes and errors to standard error, each line with `tendond: ` before it.
Where the output is no terminal there are no colours and no progress; `NO_COLOR` is honoured. `--json` prints the result
as JSON and nothing else. Of a reader of the output that goes away, as in `tendond config show | head`, nothing is said;
the status is 1.

## Completion

`tendond --install-completion` completes commands, options, laws, profiles and faults in bash, zsh, fish and PowerShell.
"""


def commands_page() -> str:
    """Markdown: a section for each command."""
    return "\n".join([_HEAD, *_sections(get_command(app), ())])


def _sections(command: Any, name: tuple[str, ...]) -> Iterator[str]:
    if name:
        yield _section(command, " ".join(("tendond", *name)), level=min(len(name) + 1, 3))
    for word, inner in getattr(command, "commands", {}).items():
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
    """`--config`, `-c` FILE, of '-c, --config <path>'."""
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
    """A line of shell; what is said around a command becomes a comment."""
    start = text.find("tendond ")
    before, rest = text[:start].strip(" ,"), text[start:]
    command, comma, after = rest.partition(", ")
    if not comma or "tendond" in after:
        command, after = rest, ""
    remark = ", ".join(part for part in (before, after) if part)
    return f"{command}  # {remark}" if remark else command
