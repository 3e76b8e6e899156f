"""Progress of what takes longer than a second, on standard error: bars on a terminal, lines to a pipe.

A pipe gets the first line after a second and further ones ever more rarely, so that a log of an hour has a few dozen
of them. Nothing is printed with `quiet`, as where a command's output is JSON, or with TENDOND_PROGRESS=off.
"""

import os
import sys
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    ProgressColumn,
    SpinnerColumn,
    TaskID,
    TextColumn,
    TimeElapsedColumn,
)

T = TypeVar("T")

FIRST_SECONDS, PAUSE_SECONDS, PAUSE_MAX = 1.0, 5.0, 60.0
"""Time before the first line, and between the next two; each pause is twice the one before, up to the last [s]."""

VARIABLE = "TENDOND_PROGRESS"
"""Environment variable that says "off" where no progress is wanted."""

WORDS = ("newest", "state", "missed")
"""Fields of a task that its lines have as well."""


class Lines(Progress):
    """Progress as lines, for output that is no terminal; takes the same calls as bars do."""

    def __init__(self, *columns: ProgressColumn | str, quiet: bool = False) -> None:
        super().__init__(*columns, console=Console(stderr=True), disable=True)
        self._quiet = quiet
        self._newest: TaskID | None = None
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._print, name="progress", daemon=True)

    def start(self) -> None:
        """Begin to print."""
        if not self._quiet:
            self._thread.start()

    def stop(self) -> None:
        """End printing; a line that is being printed is finished."""
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    def add_task(self, *given: Any, **more: Any) -> TaskID:
        """Add a task; its description is printed until another task is updated."""
        self._newest = super().add_task(*given, **more)
        return self._newest

    def update(self, task_id: TaskID, **more: Any) -> None:
        """Update a task, which is then the one that is printed."""
        self._newest = task_id
        super().update(task_id, **more)

    def _print(self) -> None:
        began, pause = time.monotonic(), FIRST_SECONDS
        while not self._ended.wait(pause):
            if line := self._line():
                with suppress(OSError):
                    print(f"tendond: {line}, {time.monotonic() - began:.0f} s", file=sys.stderr, flush=True)
            pause = PAUSE_SECONDS if pause == FIRST_SECONDS else min(2.0 * pause, PAUSE_MAX)

    def _line(self) -> str:
        newest = self._newest
        for task in self.tasks:
            if task.id == newest:
                count = "" if task.total is None else f"{task.completed:g} of {task.total:g}"
                words = [str(task.fields[name]) for name in WORDS if task.fields.get(name)]
                return ", ".join(part for part in (" ".join([task.description, count]).strip(), *words) if part)
        return ""


def bars(*columns: ProgressColumn | str, quiet: bool = False) -> Progress:
    """Return progress with these columns: bars on a terminal, lines to a pipe, nothing where `quiet`."""
    console = Console(stderr=True)
    quiet = quiet or os.environ.get(VARIABLE) == "off"
    if quiet or not console.is_terminal:
        return Lines(*columns, quiet=quiet)
    return Progress(*columns, console=console, transient=True)


class Work:
    """Work in progress, of which one thing after another is done."""

    def __init__(self, progress: Progress, task: TaskID, what: str) -> None:
        self._progress, self._task, self._what = progress, task, what

    def update(self, text: str) -> None:
        """Say what is done now."""
        self._progress.update(self._task, description=f"{self._what}: {text}" if self._what else text)


@contextmanager
def working(what: str, *, quiet: bool = False) -> Iterator[Work]:
    """Show a spinner, the work and its time, until the block ends.

    Args:
        what: "plotting run.mcap"; what is done of it now can be told by `Work.update`.
        quiet: print nothing.
    """
    columns = (SpinnerColumn(), TextColumn("{task.description}", markup=False), TimeElapsedColumn())
    with bars(*columns, quiet=quiet) as progress:
        yield Work(progress, progress.add_task(what, total=None), what)


def tracked(items: Iterable[T], total: int, what: str, *, quiet: bool = False) -> Iterator[T]:
    """Yield items, and count them.

    Args:
        items: of which each takes time. total: how many there are.
        what: they are, such as "runs". quiet: print nothing.
    """
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with bars(*columns, quiet=quiet) as progress:
        task = progress.add_task(what, total=total)
        for item in items:
            yield item
            progress.update(task, advance=1)
