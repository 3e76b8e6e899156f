"""A log as numpy arrays with names and units, a row per cycle."""

import difflib
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.errors import UsageError
from tendond.daemon.recording.channels import CYCLE, TIMING, TRUTH
from tendond.offline.logs import stretches
from tendond.offline.logs.run import Run, no_cycles, open_run
from tendond.offline.logs.units import column_name, components, unit_of
from tendond.schemas.base import SCHEMA_VERSION
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.record import RECORD_VERSION

LOG_TIME = "log_time_ns"
LEFT_OUT = ("inputs.reference",)
"""A request's own tables, which are no numbers of the cycle."""

SUGGESTED = 3
"""Names that are suggested for one that does not exist."""


class NameNotFoundError(UsageError, KeyError):
    """A name that is neither an array of a log nor a column of its table."""

    __str__ = Exception.__str__  # KeyError's would put the whole message in quotation marks


@dataclass(frozen=True, repr=False)
class Arrays:
    """A run, column by column. A notebook shows its stretches that track in a table.

    `run["command.displacement"]` has shape (cycles, tendons), `run["command_displacement_0_m"]` is a column of it. The
    names are those of the record (`tendond.schemas.record`) with dots between, with the place behind the rows of a
    sensor's reading; `timing.` and `truth.` stand before what the loop and the simulator say. Numbers that a cycle does
    not have are NaN, texts are empty; several texts of a cycle have '; ' between.

    Attributes:
        path: the log.
        config: the rig's configuration.
        metadata: revision and versions, by name.
        arrays: the arrays by name; shapes (cycles,) or (cycles, components).
        units: their units by name; empty where there is none.
    """

    path: Path
    config: RigConfig
    metadata: dict[str, str]
    arrays: dict[str, NDArray[Any]]
    units: dict[str, str]

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return an array by its name, or one of `columns` by its name.

        Raises:
            NameNotFoundError: there is none; the message has the nearest names.
        """
        if name in self.arrays:
            return self.arrays[name]
        columns = self.columns()
        if name in columns:
            return columns[name]
        raise NameNotFoundError(f"{self.path}: has no '{name}'; {_nearest(name, self.names, list(columns))}")

    def __repr__(self) -> str:
        return stretches.text(self)

    def _repr_html_(self) -> str:
        return stretches.html(self)

    def __len__(self) -> int:
        """Cycles."""
        return len(self.arrays["tick"])

    @property
    def names(self) -> list[str]:
        """Names of the arrays."""
        return list(self.arrays)

    def columns(self) -> dict[str, NDArray[Any]]:
        """One-dimensional arrays by names with component and unit: `command_displacement_0_m`."""
        found = {}
        for name, array in self.arrays.items():
            if array.ndim == 1:
                found[column_name(name, unit=self.units[name])] = array
            else:
                for i, component in enumerate(components(name, array.shape[1])):
                    found[column_name(name, component, self.units[name])] = array[:, i]
        return found

    def to_pandas(self, *names: str) -> Any:
        """Return a pandas.DataFrame with a row per cycle and the columns of `columns`.

        Args:
            names: of arrays and columns to take; default: all.

        Raises:
            NameNotFoundError: a name is not in the log.
            UsageError: pandas is not installed.
        """
        try:
            import pandas
        except ImportError as error:
            raise UsageError("a DataFrame needs pandas: pip install 'tendond[notebook]'; or use columns()") from error
        columns = self.columns()
        if names:
            columns = {
                column: values
                for name in names
                for column, values in ({name: self[name]} if name in columns else self._part(name).columns()).items()
            }
        return pandas.DataFrame(columns)

    def _part(self, name: str) -> "Arrays":
        """Return the run with one of its arrays."""
        return replace(self, arrays={name: self[name]})


def load(path: str | Path) -> Arrays:
    """Read a log of `tendond run` or `tendond replay`, with all the files that it was spread over.

    Raises:
        LogError: no file, not an MCAP file, not one of ours, damaged, without configuration or cycles, or of another
            version.
    """
    run = open_run(Path(path))
    rows = list(_rows(run))
    if not rows:
        raise no_cycles(Path(path), complete=run.complete)
    names = list(dict.fromkeys(name for row in rows for name in row))
    arrays = {name: _array([row.get(name) for row in rows]) for name in names}
    kinds = {sensor.name: sensor.kind for sensor in run.config.sensors}
    return Arrays(Path(path), run.config, run.metadata, arrays, {name: unit_of(name, kinds) for name in names})


def _rows(run: Run) -> Iterator[dict[str, Any]]:
    """Yield a row for each cycle, with the timing and truth written beside it."""
    row: dict[str, Any] = {}
    for topic, message in run.messages((CYCLE.topic, TIMING.topic, TRUTH.topic)):
        data = _checked(run, topic, message.data)
        if topic == CYCLE.topic:
            if row:
                yield row
            row = {LOG_TIME: message.log_time}
            _flatten("", data, row)
        elif row:
            _flatten("timing" if topic == TIMING.topic else "truth", data, row)
    if row:
        yield row


def _checked(run: Run, topic: str, data: bytes) -> dict[str, Any]:
    """Return a message with the present names; an unknown version is refused: its numbers could mean something else."""
    try:
        found = json.loads(data)
        present = RECORD_VERSION if topic == CYCLE.topic else SCHEMA_VERSION
        if found.get("version", present) == present and "rehearsal_us" not in found:
            return dict(found)
    except (ValueError, AttributeError):
        pass
    model = {channel.topic: channel.model for channel in (CYCLE, TIMING, TRUTH)}[topic]
    return run.decode(topic, model, data).model_dump(mode="json")


def _flatten(path: str, value: Any, row: dict[str, Any]) -> None:
    if path in LEFT_OUT or path.rsplit(".", 1)[-1] == "version":
        return
    if isinstance(value, dict) and path.rsplit(".", 1)[-1] == "unreadable":
        row[path] = "; ".join(f"{count} {reason}" for reason, count in value.items())
    elif isinstance(value, dict):
        for key, inner in value.items():
            _flatten(f"{path}.{key}" if path else key, inner, row)
    elif isinstance(value, list) and path.endswith(".rows"):
        row.update({f"{path}.{place}": numbers for place, numbers in enumerate(value) if numbers is not None})
    elif isinstance(value, list) and all(isinstance(item, str) for item in value):
        row[path] = "; ".join(value)
    elif value is not None:
        row[path] = value


def _nearest(wrong: str, names: list[str], columns: list[str]) -> str:
    """Suggest the nearest names: those that end alike, and those that are spelt alike; columns for one without dots."""
    names = names if "." in wrong else [*names, *columns]
    found = sorted((name for name in names if name.endswith(f".{wrong}")), key=len)
    found += [name for name in difflib.get_close_matches(wrong, names, SUGGESTED) if name not in found]
    suggestion = " or ".join(f"'{name}'" for name in found[:SUGGESTED])
    return f"did you mean {suggestion}?" if found else "run.names lists all names"


def _array(values: list[Any]) -> NDArray[Any]:
    """Stack one field's values over all cycles; fill those that lack it."""
    present = [value for value in values if value is not None]
    kind = present[0]
    if isinstance(kind, list):
        width = max(len(value) for value in present)
        filled = np.full((len(values), width), np.nan)
        for i, value in enumerate(values):
            if value is not None:
                filled[i, : len(value)] = value
        return filled
    if isinstance(kind, str):
        return np.array(["" if value is None else value for value in values])
    if len(present) == len(values) and all(isinstance(value, type(kind)) for value in present):
        return np.array(values)
    return np.array([np.nan if value is None else float(value) for value in values])
