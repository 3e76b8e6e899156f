"""`tendond log list`, `tag`, `note`, `prune`, `verify`."""

import json
import re
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path

from tendond.cli.common import SYSTEM_LOGS, load_config, log_folder, say
from tendond.daemon.errors import UsageError
from tendond.daemon.recording.storage.retention import DAY, GIGABYTE, retention
from tendond.daemon.recording.storage.run_notes import SUFFIX as NOTES
from tendond.daemon.recording.storage.run_notes import (
    TAG,
    Note,
    RunNotes,
    RunNotesError,
    notes_path,
    read_notes,
    write_notes,
)
from tendond.offline.files import as_text
from tendond.offline.log_index.index import RunEntry, list_runs
from tendond.offline.log_index.verify import Verified, verify
from tendond.offline.logs.run import open_run


def run_list(folder: Path | None, tags: list[str], search: str, *, as_json: bool) -> None:
    """Print the runs of a folder; see `tendond log list --help`.

    Raises:
        UsageError: the folder cannot be read.
    """
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

    folder = folder or log_folder()
    console = Console(stderr=True)
    columns = (TextColumn("reading logs"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=console, disable=not console.is_terminal, transient=True) as progress:
        task = progress.add_task("", total=None)
        runs = list_runs(folder, lambda done, count: progress.update(task, completed=done, total=count))
    found = [run for run in runs if run.matches(tags, search)]
    if as_json:
        print(json.dumps([run.as_json() for run in found], indent=2))
        return
    if not found:
        say(f"{folder}: no such runs, of {len(runs)}" if runs else f"{folder}: no logs")
        return
    _print_table(found)
    for run in found:
        if run.problem:
            say(f"{as_text(run.files[0])}: {run.problem}")


HEADINGS = ("run", "started (UTC)", "s", "MB", "law", "reference")
RIGHT = ("s", "MB")


def _print_table(runs: list[RunEntry]) -> None:
    """Print a line for each run, and below it what there is of faults, tags and notes."""
    rows = [
        (
            as_text(run.run),
            run.started[:16].replace("T", " "),
            f"{run.duration_s:.1f}",
            f"{run.bytes / 1e6:.1f}",
            run.law.replace("_", " "),
            run.reference.replace("_", " "),
        )
        for run in runs
    ]
    widths = [max(map(len, column)) for column in zip(HEADINGS, *rows, strict=True)]
    for run, row in zip([None, *runs], [HEADINGS, *rows], strict=True):
        cells = [
            cell.rjust(width) if name in RIGHT else cell.ljust(width)
            for name, cell, width in zip(HEADINGS, row, widths, strict=True)
        ]
        print("  ".join(cells).rstrip())
        more = {} if run is None else {
            "faults": _health(run), "tags": " ".join(run.tags), "notes": "; ".join(note.text for note in run.notes)
        }  # fmt: skip
        for name, text in more.items():
            if text:
                print(f"    {name}: {text}")


def _health(run: RunEntry) -> str:
    """Return the faults of a run, each once, or what is wrong with its files."""
    if run.faults:
        return "; ".join(dict.fromkeys(run.faults))
    if run.problem:
        return "cannot be read"
    return "" if run.complete else "not finished"


def run_tag(file: Path, tags: list[str], *, remove: bool) -> None:
    """Add or remove tags of a run, and print those that it has; see `tendond log tag --help`.

    Raises:
        LogError: the log cannot be used. UsageError: an invalid tag, or tags that cannot be read or written.
    """
    for tag in tags:
        if not re.fullmatch(TAG, tag):
            raise UsageError(f"'{tag}' is no tag: use 1 to 32 of a-z, 0-9, '-', '_', starting with a letter or digit")
    path, before = _notes_of(file)
    kept = [tag for tag in before.tags if not (remove and tag in tags)]
    now = tuple(dict.fromkeys(kept if remove else [*kept, *tags]))
    if now != before.tags:
        _write(path, before.model_copy(update={"tags": now}))
    print(f"{_run_of(path)}: {' '.join(now) or 'no tags'}")


def run_note(file: Path, text: str | None) -> None:
    """Add a note to a run, or print its notes; see `tendond log note --help`.

    Raises:
        LogError: the log cannot be used. UsageError: notes that cannot be read or written.
    """
    path, before = _notes_of(file)
    if text is not None:
        if not text.strip():
            raise UsageError("an empty note: give a text in quotes")
        note = Note(time=datetime.now(UTC).isoformat(timespec="seconds"), text=text.strip())
        before = before.model_copy(update={"notes": (*before.notes, note)})
        _write(path, before)
    for note in before.notes:
        print(f"{note.time}  {note.text}")
    if not before.notes:
        say(f"{_run_of(path)}: no notes")


def _notes_of(file: Path) -> tuple[Path, RunNotes]:
    """Return the path of a run's tags and notes, and what is in it."""
    path = notes_path(file.parent, open_run(file, whole=False).name)
    try:
        return path, read_notes(path)
    except RunNotesError as error:
        raise UsageError(str(error)) from error


def _run_of(path: Path) -> str:
    return as_text(path.name.removesuffix(NOTES))


def _write(path: Path, notes: RunNotes) -> None:
    try:
        write_notes(path, notes)
    except OSError as error:
        raise UsageError(
            f"{error.filename or path}: {error.strerror}; as the owner of the logs: sudo -u tendond tendond ..."
        ) from error


def run_prune(
    folder: Path | None,
    config_file: Path | None,
    keep_size: float | None,
    keep_days: float | None,
    *,
    yes: bool,
    as_json: bool,
) -> None:
    """Print or remove the logs beyond the bounds; see `tendond log prune --help`.

    Raises:
        ConfigError: the configuration cannot be used. UsageError: the folder cannot be read, or there are no bounds.
    """
    folder = folder or log_folder()
    config = load_config(config_file)
    given = {"keep_size": keep_size, "keep_days": keep_days}
    section = config.log.model_copy(update={key: value for key, value in given.items() if value is not None})
    if not folder.is_dir():
        raise UsageError(f"{folder}: is not a folder; give that of the logs")
    service = folder.resolve().is_relative_to(SYSTEM_LOGS)
    bounds = retention(section, folder, config.rig.name, service=service)
    if not bounds.is_bounded:
        raise UsageError(
            "no bounds: set log.keep_size or log.keep_days in the configuration, or give --keep-size or --keep-days"
        )
    found = bounds.plan()
    removed = set(bounds.prune(0.0)) if yes else set()
    if as_json:
        rows = [{**asdict(one), "path": str(one.path), "removed": one.path in removed} for one in found]
        print(json.dumps(rows, indent=2))
        return
    limits = {
        "age": f"older than {(bounds.age or 0.0) / DAY:g} days",
        "size": f"beyond {(bounds.size or 0.0) / GIGABYTE:g} GB",
    }
    for one in found:
        print(f"{one.path.name}  {one.size / 1e6:.1f} MB  {one.days:.1f} days old: {limits[one.reason]}")
    total = sum(one.size for one in found) / 1e6
    if not found:
        names = f"{config.rig.name}-TIME.mcap"
        print(f"{folder}: no log of rig '{config.rig.name}', named {names} by tendond run, is beyond its bounds")
    elif yes:
        print(f"removed {len(removed)} files of {len(found)}, {total:.1f} MB")
    else:
        say(f"{len(found)} files, {total:.1f} MB: not removed; add --yes")


def run_verify(paths: list[Path], *, record: bool, as_json: bool) -> bool:
    """Compare logs with their checksums; return whether none has changed. See `tendond log verify --help`.

    Raises:
        UsageError: a file or folder cannot be read.
    """
    files: list[Path] = []
    for path in paths:
        files += sorted(path.glob("*.mcap")) if path.is_dir() else [path]
    found: list[Verified] = []
    for file in files:
        one = verify(file, record=record)
        found.append(one)
        if not as_json:
            print(f"{file}: {one.verdict}" + (f" ({one.remark})" if one.remark else ""), flush=True)
    if as_json:
        print(json.dumps([{**asdict(one), "path": str(one.path)} for one in found], indent=2))
    if not files:
        say("no logs there")
    return all(one.verdict != "changed" for one in found)
