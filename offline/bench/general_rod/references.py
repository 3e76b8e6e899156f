"""Table of the general rod beside textbooks, a plain solver and others' data: found, target, passed."""

import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

import tendond
from tendond.model.errors import ConvergenceError
from tendond.offline.bench.general_rod import others, textbooks

STEP_TOLERANCE = {0.001: 0.002, 0.005: 0.0035}
"""Mean distance from SoRoSim's releases, in parts of the length, by time step [s]."""


@dataclass(frozen=True)
class ReferenceRow:
    """A line of the table.

    Attributes:
        source: of the figure. quantity: what is compared.
        found, target: our figure, which must not exceed the target; none: not compared, `note` says why.
        unit: of both; 'L' is the robot's length.
        note: why there is no figure.
    """

    source: str
    quantity: str
    found: float | None
    target: float
    unit: str
    note: str = ""

    @property
    def passed(self) -> bool | None:
        """True if the target is met; none where nothing was compared."""
        return None if self.found is None else bool(self.found <= self.target)


def compare(folder: Path, progress: Callable[[str], None] = lambda name: None) -> list[ReferenceRow]:
    """Return every row; `progress` is called with the name of the next one. Takes about a minute."""
    rows: list[ReferenceRow] = []
    for source, quantity, figure, target in (
        ("Mattiasson 1981", "elastica, P L^2/EI to 5", textbooks.elastica, 1e-4),
        ("Argyris & Symeonidis 1981", "follower, P L^2/EI to 10", textbooks.follower, 1e-4),
        ("Greenhill 1881", "weight that buckles, relative", textbooks.heavy_column, 1e-3),
        ("closed form", "helix of two turns", textbooks.helix, 1e-4),
        ("Bathe & Bolourchi 1979", "45 degree bend, 600 lb", textbooks.curved_cantilever, 1e-4),
    ):
        progress(quantity)
        rows.append(ReferenceRow(source, quantity, figure(), target, "" if "relative" in quantity else "L"))
    progress("routing")
    rows.append(_routing())
    for rows_of in (_statics, _releases, _two_tendons):
        rows += rows_of(folder, progress)
    return rows


def _routing() -> ReferenceRow:
    """Routing, beside the plain solver that is part of the tests: no figure where they are not installed."""
    source, quantity, target = "plain solver", "converging, helical, ending tendons", 1e-5
    root = Path(tendond.__file__).resolve().parent.parent
    if not (root / "tests" / "reference").is_dir():
        return ReferenceRow(source, quantity, None, target, "L", "the tests are not installed")
    sys.path.insert(0, str(root))
    try:
        plain: Any = importlib.import_module("tests.reference.routing")
    finally:
        sys.path.remove(str(root))
    return ReferenceRow(source, quantity, textbooks.routing(plain.solve_routing, plain.Piece), target, "L")


def _statics(folder: Path, progress: Callable[[str], None]) -> Iterator[ReferenceRow]:
    for material in others.MATERIALS:
        file = others.statics_file(folder, material)
        source, median = f"SoRoSim statics, {material}", "equilibria, median"
        if not file.exists():
            yield ReferenceRow(source, median, None, 0.0005, "L", f"{file.name} is not there")
            continue
        progress(source)
        errors = others.equilibria(folder, material)
        yield ReferenceRow(source, f"{len(errors)} {median}", float(np.nanmedian(errors)), 0.0005, "L")
        yield ReferenceRow(source, "equilibria, max", float(np.nanmax(errors)), 0.005, "L")
        yield ReferenceRow(source, "equilibria not found", float(np.isnan(errors).sum()), 0.0, "")


def _releases(folder: Path, progress: Callable[[str], None]) -> Iterator[ReferenceRow]:
    there = [number for number in others.RELEASES if others.release_file(folder, number).exists()]
    for time_step, target in STEP_TOLERANCE.items():
        source = "SoRoSim releases, steel"
        quantity = f"{len(there)} of 10 s at {1e3 * time_step:g} ms, mean"
        if not there:
            yield ReferenceRow(source, quantity, None, target, "L", "the files are not there")
            continue
        means = []
        for number in there:
            progress(f"release {number} at {1e3 * time_step:g} ms")
            try:
                means.append(float(np.mean(others.release(folder, number, time_step))))
            except ConvergenceError:
                means.append(np.inf)
        yield ReferenceRow(source, quantity, float(np.mean(means)), target, "L")


def _two_tendons(folder: Path, progress: Callable[[str], None]) -> Iterator[ReferenceRow]:
    names = ("soromox", "sorosim")
    quantity = "rod with two tendons, mean; target: between SoRoMoX and SoRoSim"
    if not all(others.rollout_file(folder, name).exists() for name in names):
        yield ReferenceRow("SoRoMoX", quantity, None, 0.0048, "m", "the files are not there")
        return
    progress("rod with two tendons")
    found = others.two_tendons(folder)
    for name, source in zip(names, ("SoRoMoX", "SoRoSim"), strict=True):
        yield ReferenceRow(source, quantity, found[name], found["between"], "m")


def as_json(rows: list[ReferenceRow]) -> list[dict[str, Any]]:
    """The rows as plain data."""
    return [{**asdict(row), "passed": row.passed} for row in rows]


def cells(rows: list[ReferenceRow]) -> tuple[list[str], list[list[str]]]:
    """Format header and lines of the table."""
    lines = []
    for row in rows:
        found = row.note if row.found is None else f"{row.found:.3g} {row.unit}".strip()
        said = {True: "yes", False: "NO", None: "-"}[row.passed]
        lines.append([row.source, row.quantity, found, f"{row.target:.3g} {row.unit}".strip(), said])
    return ["source", "quantity", "found", "target", "passed"], lines
