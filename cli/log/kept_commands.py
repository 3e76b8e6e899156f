"""Commands of `tendond log` on the logs of a folder: options and help."""

from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from tendond.cli.options import Config, Json

Folder = Annotated[
    Path | None, typer.Argument(metavar="[FOLDER]", help="Folder of the logs. Default: log.", show_default=False)
]
LogFile = Annotated[Path, typer.Argument(metavar="LOG", help="Any file of the run.", show_default=False)]


def list_logs(
    folder: Folder = None,
    tag: Annotated[
        list[str] | None, typer.Option("--tag", help="Only runs with this tag; may be repeated: with all of them.")
    ] = None,
    search: Annotated[
        str, typer.Option("--search", help="Only runs with this text in name, law, faults, tags, notes.")
    ] = "",
    json: Json = False,
) -> None:
    """List the runs of a folder, the oldest first.

    Date, duration, law, reference, size, faults, tags and notes. What was read is kept in FOLDER/.tendond-index.json,
    which may be removed.

    Examples: tendond log list; tendond log list /var/log/tendond/bench --search overload --json
    """
    from tendond.cli.log.kept import run_list

    run_list(folder, tag or [], search, as_json=json)


def tag_log(
    file: LogFile,
    tags: Annotated[
        list[str] | None, typer.Argument(metavar="[TAG]...", help="Words of a-z, 0-9, - and _.", show_default=False)
    ] = None,
    remove: Annotated[bool, typer.Option("--remove", help="Remove the tags.")] = False,
) -> None:
    """Tag a run, or print its tags.

    A run with a tag is never removed, neither by the controller nor by 'tendond log prune'. Tags and notes are in
    RUN.notes.json beside the log, which stays as it is.

    Example: tendond log tag bench-20261130T120000Z.mcap demo paper-figure-3
    """
    from tendond.cli.log.kept import run_tag

    run_tag(file, tags or [], remove=remove)


def note_log(
    file: LogFile,
    text: Annotated[
        str | None, typer.Argument(metavar="[TEXT]", help="Note to add. Default: print them.", show_default=False)
    ] = None,
) -> None:
    """Add a note to a run, or print its notes.

    Example: tendond log note run.mcap "tendon 2 was slack, replaced afterwards"
    """
    from tendond.cli.log.kept import run_note

    run_note(file, text)


def prune_logs(
    folder: Folder = None,
    config: Config = None,
    keep_size: Annotated[
        float | None, typer.Option("--keep-size", min=0.0, help="Instead of log.keep_size [GB]; 0: no limit.")
    ] = None,
    keep_days: Annotated[
        float | None, typer.Option("--keep-days", min=0.0, help="Instead of log.keep_days [days]; 0: no limit.")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Remove them; without it they are only listed.")] = False,
    json: Json = False,
) -> None:
    """List the logs beyond the bounds; --yes removes them.

    Each with the reason. The bounds are log.keep_size and log.keep_days, which the controller keeps by itself. Of the
    configuration's rig, files named RIG-TIME.mcap; never one that is being written, nor one of a run with a tag.

    Example: tendond log prune /var/log/tendond/bench --config rig.toml --keep-days 30 --yes
    """
    from tendond.cli.log.kept import run_prune

    run_prune(folder, config, keep_size, keep_days, yes=yes, as_json=json)


def verify_logs(
    paths: Annotated[
        list[Path], typer.Argument(metavar="LOG...", help="Log files, or folders of them.", show_default=False)
    ],
    record: Annotated[bool, typer.Option("--record", help="Where there is no checksum, write one now.")] = False,
    json: Json = False,
) -> None:
    """Compare logs with their checksums.

    These are made while a log is written, and are in LOG.sha256, as sha256sum reads it. Exit status 1: a file has
    changed.

    Example: tendond log verify /var/log/tendond/bench
    """
    from tendond.cli.log.kept import run_verify

    if not run_verify(paths, record=record, as_json=json):
        raise typer.Exit(1)


LIBRARY: dict[str, Callable[..., None]] = {
    "list": list_logs,
    "tag": tag_log,
    "note": note_log,
    "prune": prune_logs,
    "verify": verify_logs,
}
"""Commands by name, in the order of the help."""
