"""The campaign: many runs in parallel processes, kept in a file as they come, so that it can be stopped and resumed."""

import csv
import io
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, fields
from functools import partial
from pathlib import Path

from tendond import TendondError
from tendond.offline.safety.run import Outcome, run

FILE = "runs.csv"
"""Name of the file of outcomes in the campaign's folder."""

COMPARED = 4
"""One run in so many is made without the filter too."""


@dataclass(frozen=True)
class Row:
    """Runs of a law, a robot or a kind of constraint.

    Attributes:
        name: what they share. runs: number of them. violations: true plants beyond a constraint while under control.
        released: the same with those of a release. clearance: smallest distance from a constraint [-], of the length,
            or of strain_max. compared: runs without the filter; without: violations in these.
        altered: part of the cycles in which the filter altered the command. unkept: runs in which no command kept
            the constraints at some time. faults: runs that ended in one.
    """

    name: str
    runs: int
    violations: int
    released: int
    clearance: float
    compared: int
    without: int
    altered: float
    unkept: int
    faults: int


def outcome_of(seed: int, compared: int = COMPARED) -> Outcome:
    """Run a seed; one in `compared` without the filter too, none if it is 0."""
    return run(seed, compare=compared > 0 and seed % compared == 0)


def campaign(seeds: Sequence[int], processes: int | None, out: Path, compared: int = COMPARED) -> Iterator[Outcome]:
    """Yield the outcomes of the seeds that the folder's file does not have yet, and add each to it.

    Args:
        seeds: of the runs. processes: parallel ones; none: one per processor. out: folder. compared: see `outcome_of`.

    Raises:
        TendondError: a run has no solution, or the file is not one of this campaign.
        OSError: the folder cannot be written.
    """
    out.mkdir(parents=True, exist_ok=True)
    done = {one.seed for one in read(out)}
    left = [seed for seed in seeds if seed not in done]
    with (out / FILE).open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Outcome)])
        if not done and file.tell() == 0:
            writer.writeheader()
        with ProcessPoolExecutor(processes) as pool:
            for outcome in pool.map(partial(outcome_of, compared=compared), left):
                writer.writerow(asdict(outcome))
                file.flush()
                yield outcome


def read(out: Path) -> list[Outcome]:
    """Return the outcomes in a campaign's folder, in the order of their seeds; none where there is no file.

    Raises:
        TendondError: the file is not one of a campaign.
    """
    path = out / FILE
    if not path.exists():
        return []
    try:
        rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))
        found = [_outcome(row) for row in rows]
    except (KeyError, TypeError, ValueError) as error:
        raise TendondError(f"{path}: is not a file of this study ({error}): choose another --out") from error
    return sorted(found, key=lambda one: one.seed)


def _outcome(row: dict[str, str]) -> Outcome:
    without = row["without"]
    return Outcome(
        int(row["seed"]), row["robot"], row["law"], row["kind"], float(row["clearance"]), float(row["released"]),
        float(without) if without else None, int(row["altered"]), int(row["unkept"]), row["ended"],
    )  # fmt: skip


def summary(outcomes: Sequence[Outcome], cycles: int) -> list[Row]:
    """Return a row for all runs, then one for each law, robot and kind of constraint; `cycles` of each run."""
    rows = [_row("all", outcomes, cycles)]
    for key in ("law", "robot", "kind"):
        for name in sorted({getattr(one, key) for one in outcomes}):
            rows.append(_row(f"{key}: {name}", [one for one in outcomes if getattr(one, key) == name], cycles))
    return rows


def _row(name: str, some: Sequence[Outcome], cycles: int) -> Row:
    compared = [one.without for one in some if one.without is not None]
    return Row(
        name=name,
        runs=len(some),
        violations=sum(one.clearance < 0.0 for one in some),
        released=sum(one.released < 0.0 for one in some),
        clearance=min((one.clearance for one in some), default=float("nan")),
        compared=len(compared),
        without=sum(one < 0.0 for one in compared),
        altered=sum(one.altered for one in some) / max(1, len(some) * cycles),
        unkept=sum(one.unkept > 0 for one in some),
        faults=sum(bool(one.ended) for one in some),
    )


def markdown(rows: Sequence[Row]) -> str:
    """Write the rows as a table."""
    lines = [
        "| runs of | runs | violations | with a release | smallest distance | without | altered | unkept | faults |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {one.name} | {one.runs} | {one.violations} | {one.released} | {one.clearance:.4f} | "
        f"{one.without} of {one.compared} | {100.0 * one.altered:.0f} % | {one.unkept} | {one.faults} |"
        for one in rows
    ]
    return "\n".join(lines)


def meets(rows: Sequence[Row]) -> bool:
    """Return whether no plant broke a constraint, and some did without the filter where that was tried."""
    whole = rows[0]
    return whole.violations == 0 and (whole.compared == 0 or whole.without > 0)
