"""Results on disk during a run, one per line, so that an interrupted run can be resumed."""

import fcntl
import json
import os
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any

from tendond.daemon.errors import UsageError
from tendond.offline.robustness.evaluate import RESULT_COLUMNS, PointResult
from tendond.offline.robustness.points import Point

NAME = "results.jsonl"


class ResultsFile:
    """Results of a folder, kept as they come; the first line has the settings, each other one a result.

    Args:
        folder: folder of the results; created if missing.
        settings: the run's settings.
        fresh: ignore existing results.

    Raises:
        UsageError: another run writes to it, or it holds results of other settings, or something else.
        OSError: it cannot be written.
    """

    def __init__(self, folder: Path, settings: dict[str, Any], *, fresh: bool = False) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.path = folder / NAME
        self.results: dict[str, PointResult] = {}
        self._stream = self.path.open("a+b")
        try:
            try:
                fcntl.flock(self._stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise UsageError(f"{folder}: another run writes its results there; choose another --out") from None
            if fresh:
                self._stream.truncate(0)
            self._read(settings)
        except BaseException:
            self._stream.close()
            raise

    def __enter__(self) -> "ResultsFile":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stream.close()

    def add(self, point: Point, result: PointResult) -> None:
        """Write a result, and let it leave this process."""
        self.results[point.key] = result
        self._write({"point": point.key, **asdict(result)})

    def _write(self, values: dict[str, Any]) -> None:
        self._stream.write(json.dumps(values, allow_nan=False).encode() + b"\n")
        self._stream.flush()

    def _read(self, settings: dict[str, Any]) -> None:
        self._stream.seek(0)
        content = self._stream.read()
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):  # ended in the middle of a line
            self._stream.truncate(len(whole))
            self._stream.seek(0, os.SEEK_END)
        lines = whole.splitlines()
        if not lines:
            self._write({"settings": settings})
            return
        try:
            self._compare(json.loads(lines[0])["settings"], settings)
            for line in lines[1:]:
                values = json.loads(line)
                self.results[values["point"]] = PointResult(**{name: values[name] for name in RESULT_COLUMNS})
        except (ValueError, KeyError, TypeError):
            raise UsageError(f"{self.path}: is not a results file of this program; start again with --fresh") from None

    def _compare(self, theirs: dict[str, Any], ours: dict[str, Any]) -> None:
        differences = _differences(theirs, ours)
        if differences:
            raise UsageError(
                f"{self.path.parent}: holds results of other settings ({'; '.join(differences[:4])}); "
                "choose another folder with --out, or discard them with --fresh"
            )


def _differences(theirs: Any, ours: Any, name: str = "") -> list[str]:
    """List the differences of two nested tables: 'name: theirs, now ours'."""
    if isinstance(theirs, dict) and isinstance(ours, dict):
        return [
            line
            for key in {**theirs, **ours}
            for line in _differences(theirs.get(key), ours.get(key), f"{name}.{key}" if name else key)
        ]
    return [] if theirs == ours else [f"{name}: {theirs}, now {ours}"]
