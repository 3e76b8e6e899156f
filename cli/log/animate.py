"""`tendond log animate`: a run as a movie, with progress."""

from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import Progress

from tendond.cli.common import say
from tendond.cli.log.figures import not_writable
from tendond.daemon.errors import UsageError

QUARTERS = 4
"""Lines of progress, where it does not go to a terminal."""


def run_animate(
    file: Path,
    out: Path | None,
    formats: tuple[str, ...],
    number: int,
    span: tuple[float, float],
    speed: float,
    rate: int,
    width: int,
    *,
    force: bool,
) -> None:
    """Write the movie of a run.

    Args:
        file: the log. out: file to write. formats: of the files, where there is no `out`.
        number: of the run, from 1. span: first and last time since its start [s].
        speed: of the movie beside the run's. rate: pictures a second. width: of a picture [pixels].
        force: replace files.

    Raises:
        LogError: the log cannot be used. UsageError: it has no such run or time, or ffmpeg is not installed.
        DaemonError: a file exists, or cannot be written.
    """
    from tendond.offline.logs.log import load
    from tendond.offline.logs.metrics import runs
    from tendond.offline.movies.files import check_formats, write_movies
    from tendond.offline.plots.output import check_new

    check_formats(formats)
    log = load(file)
    if log.cut:
        say(log.cut)
    found = runs(log)
    if number > len(found):
        has = "one run" if len(found) == 1 else f"{len(found)} runs; choose --run 1 to {len(found)}"
        raise UsageError(f"{file}: has {has}")
    stem = f"{file.stem}-run{number}" if number > 1 else file.stem
    paths = [out] if out is not None else [file.with_name(f"{stem}.{form}") for form in formats]
    check_new(paths, force=force)
    run = found[number - 1]
    first, last = span[0], min(span[1], float(run.time[-1]))
    if first >= last:
        raise UsageError(f"--from {first:g}: the run has {run.time[-1]:.2f} s")
    times = np.arange(first, last + 1e-9, speed / rate)
    from tendond.offline.movies.scene import COLOURS, Scene

    scene = Scene(log, run, width, (first, last))
    try:
        for path in paths:
            path.parent.mkdir(parents=True, exist_ok=True)
        write_movies(paths, lambda: (scene.picture(time) for time in _progress(times.tolist())), COLOURS, rate)
    except OSError as error:
        raise not_writable(paths[0], error) from error
    for path in paths:
        print(f"{path}: {len(times)} pictures, {path.stat().st_size / 1e6:.2f} MB")


def _progress(times: list[float]) -> Iterator[float]:
    """Yield the times, with a bar on a terminal, and with lines elsewhere."""
    console = Console(stderr=True)
    if console.is_terminal:
        with Progress(console=console, transient=True) as progress:
            yield from progress.track(times, description="drawing")
        return
    yield from _with_lines(times)


def _with_lines(times: Iterable[float]) -> Iterator[float]:
    times = list(times)
    marks = {round(len(times) * part / QUARTERS) for part in range(1, QUARTERS)}
    for count, time in enumerate(times):
        if count in marks and count:
            say(f"{count} of {len(times)} pictures")
        yield time
