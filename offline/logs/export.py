"""A log as a table for other programs: CSV, or Parquet with the extra `parquet`."""

import csv
from pathlib import Path

from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.files import whole
from tendond.offline.logs.arrays import Arrays


def check_export(path: Path) -> None:
    """Check that a table can be written in the format of a file's name, before a log is read for it.

    Raises:
        UsageError: the name of the file ends in neither .csv nor .parquet, or pyarrow is not installed.
    """
    if path.suffix not in (".csv", ".parquet"):
        raise UsageError(f"{path}: the name of the file says how it is written: end it in .csv or .parquet")
    if path.suffix == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401  # whether it is installed; the writer imports it itself
        except ImportError as error:
            raise UsageError("Parquet needs pyarrow: pip install 'tendond[parquet]', or write .csv") from error


def export(run: Arrays, path: Path) -> int:
    """Write a line per cycle, units in the names of the columns; the number of columns.

    Numbers keep every digit; one that a cycle does not have is an empty cell (CSV) or null (Parquet).

    Raises:
        UsageError: see `check_export`. DaemonError: the file cannot be written.
    """
    check_export(path)
    try:
        return _write_csv(run, path) if path.suffix == ".csv" else _write_parquet(run, path)
    except OSError as error:
        raise DaemonError(f"{path}: cannot be written: {error.strerror}; choose another file with --out") from error


def _write_csv(run: Arrays, path: Path) -> int:
    columns = run.columns()
    with whole(path) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        for row in zip(*(column.tolist() for column in columns.values()), strict=True):
            writer.writerow(["" if value != value else value for value in row])
    return len(columns)


def _write_parquet(run: Arrays, path: Path) -> int:
    import pyarrow as pa
    import pyarrow.parquet as pq

    columns = {name: pa.array(column, from_pandas=column.dtype.kind == "f") for name, column in run.columns().items()}
    notes = {f"tendond.{key}": value for key, value in run.metadata.items()}
    table = pa.table(columns).replace_schema_metadata({**notes, "tendond.rig.json": run.config.model_dump_json()})
    with whole(path) as draft:
        pq.write_table(table, draft)
    return len(columns)
