"""Give tuned constants other values and run the loop: `python -m tests.constants [NAME ...] [--processes N]`.

What the constants' docstrings say of smaller and larger values is from here. One table each for the observer, the
planar reference and the probe; the first row of a table has the constants' own values.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor

from tests.constants.observer import GAINS, print_observer
from tests.constants.probe import PROBE, print_probe
from tests.constants.reference import REFERENCE, print_reference

TABLES = ((GAINS, print_observer), (REFERENCE, print_reference), (PROBE, print_probe))


def main() -> None:
    """Print the tables of the constants that are asked for."""
    every = [name for table, _ in TABLES for name in table]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(every)}; all without one")
    parser.add_argument("--processes", type=int, default=2)
    given = parser.parse_args()
    if unknown := set(given.names) - set(every):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; choose from {', '.join(every)}")
    with ProcessPoolExecutor(given.processes) as pool:
        for table, print_rows in TABLES:
            if names := [name for name in given.names or every if name in table]:
                print_rows(names, pool)


if __name__ == "__main__":
    main()
