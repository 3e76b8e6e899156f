"""A run: settings in, results in a folder out, from wherever it was interrupted."""

import csv
import io
from collections.abc import Callable, Generator, Sequence
from contextlib import closing
from dataclasses import asdict, fields
from pathlib import Path

from tendond.daemon.control.setup import CycleSetup
from tendond.model.rods.selection import model_rod
from tendond.offline.files import write_whole
from tendond.offline.robustness.evaluate import RESULT_COLUMNS, PointResult
from tendond.offline.robustness.executors import Chunk, Done, chunks_of
from tendond.offline.robustness.open_loop import with_open_loop
from tendond.offline.robustness.plants import rig_of
from tendond.offline.robustness.points import AXES, Point, points_of
from tendond.offline.robustness.results import ResultsFile
from tendond.offline.robustness.settings import Settings
from tendond.offline.robustness.unlike import load_factor

POINT_COLUMNS = tuple(field.name for field in fields(Point))

Rows = list[tuple[Point, PointResult]]
Executor = Callable[[Sequence[Chunk]], Generator[Done, None, None]]
Report = Callable[[int, int, int], None]
"""Called with the points done, their total number, and how many miss the goal."""


def run(
    settings: Settings,
    folder: Path,
    execute: Executor,
    report: Report,
    *,
    fresh: bool = False,
    open_loop_threads: int = 0,
) -> Rows:
    """Run the points that the folder's results file does not have, and write results.csv; all of them are returned.

    Args:
        settings: the run's settings.
        folder: folder of the results.
        execute: runs chunks of points, in any order.
        report: called with the progress.
        fresh: leave aside what the folder has.
        open_loop_threads: that step the plants without feedback at the end; 0: that is left out.

    Raises:
        TendondError: settings or a folder that cannot be used; what `execute` raises.
        OSError: the folder cannot be written.
    """
    load = load_factor(model_rod(settings.config).parameters)
    points = points_of(
        settings.points, settings.laws, settings.feedbacks, count=settings.count, seed=settings.seed, load=load
    )
    for law in settings.laws:  # what is wrong with the configuration is said before anything is run
        for drive in AXES["drive"]:
            CycleSetup.from_config(rig_of(settings.config, Point("", law, "force", drive=str(drive)), settings.seed))
    with ResultsFile(folder, settings.as_json(), fresh=fresh) as kept:
        left = [(index, point) for index, point in enumerate(points) if point.key not in kept.results]
        missed = sum(not kept.results[point.key].meets for point in points if point.key in kept.results)
        done = len(points) - len(left)
        report(done, len(points), missed)
        if left:
            with closing(execute(chunks_of(settings.config, settings.seed, left))) as results:
                for chunk in results:
                    for index, result in chunk:
                        kept.add(points[index], result)
                        done, missed = done + 1, missed + (not result.meets)
                    report(done, len(points), missed)
        rows = [(point, kept.results[point.key]) for point in points]
    if open_loop_threads:
        rows = with_open_loop(settings.config, rows, open_loop_threads)
    write_whole(folder / "results.csv", csv_text(rows))
    return rows


def csv_text(rows: Rows) -> str:
    """Write a heading and a line for each point; cells without a value are empty."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow((*POINT_COLUMNS, *RESULT_COLUMNS))
    for point, result in rows:
        writer.writerow(_cell(value) for value in (*asdict(point).values(), *asdict(result).values()))
    return stream.getvalue()


def _cell(value: object) -> object:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else value
