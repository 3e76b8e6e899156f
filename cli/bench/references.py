"""`tendond bench rod --references`: the general rod beside textbooks and others' data."""

import json

from rich.console import Console

from tendond.cli.bench.tables import print_table
from tendond.cli.common import say
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.bench.general_rod.others import data_folder
from tendond.offline.bench.general_rod.references import as_json as rows_as_json
from tendond.offline.bench.general_rod.references import cells, compare
from tendond.offline.progress import working


def run_references(given: str, *, as_json: bool) -> bool:
    """Compare and print the table; return whether every target that could be compared is met.

    Raises:
        ReferenceDataError: there is no folder of others' data.
    """
    folder = data_folder(given)
    announce_compilation(say)
    with working("", quiet=as_json) as status:
        rows = compare(folder, lambda name: status.update(f"comparing {name}"))
    if as_json:
        print(json.dumps(rows_as_json(rows), indent=2))
    else:
        print_table(Console(), *cells(rows), left=2)
    return all(row.passed is not False for row in rows)
