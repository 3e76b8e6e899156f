"""A log as a table for other programs: CSV, or Parquet with the extra `parquet`."""

import csv
from pathlib import Path

from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.files import whole
from tendond.offline.logs.arrays import Arrays


def export(run: Arrays, path: Path) -> int:
    """Write a line per cycle, units in the names of the columns; the number of columns.

    Numbers keep every digit; one that a cycle does not have is an empty cell (CSV) or null (Parquet).

    Raises:
        UsageError: the name of the file ends in neither .csv nor .parquet, or pyarrow is not installed.
        DaemonError: the file cannot be written.
    """
    try:
        if path.suffix == ".csv":
            return _write_csv(run, path)
        if path.suffix == ".parquet":
            return _write_parquet(run, path)
    except OSError as error:
        raise DaemonError(f"{path}: cannot be written: {error.strerror}; choose another file with --out") from error
    raise UsageError(f"{path}: the name of the file says how it is written: end it in .csv or .parquet")


def _write_csv(run: Arrays, path: Path) -> int:
    columns = run.columns()
    with whole(path) as draft, draft.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        for row in zip(*(column.tolist() for column in columns.values()), strict=True):
            writer.writerow(["" if value != value else value for value in row])
    return len(columns)


def _write_parquet(run: Arrays, path: Path) -> int:
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError as error:
        raise UsageError("Parquet needs pyarrow: pip install 'tendond[parquet]', or write .csv") from error
    columns = {name: pa.array(column, from_pandas=column.dtype.kind == "f") for name, column in run.columns().items()}
    notes = {f"tendond.{key}": value for key, value in run.metadata.items()}
    table = pa.table(columns).replace_schema_metadata({**notes, "tendond.rig.json": run.config.model_dump_json()})
    with whole(path) as draft:
        pq.write_table(table, draft)
    return len(columns)
