"""`tendond validate`: run the validation, print and write its report."""

import json
from pathlib import Path

from rich.console import Console

from tendond.cli.bench.tables import print_table
from tendond.cli.common import say
from tendond.cli.extras import need
from tendond.daemon.errors import UsageError
from tendond.model.numerics.announce import announce_compilation
from tendond.offline.correction.learned import save
from tendond.offline.files import write_whole
from tendond.offline.progress import working
from tendond.offline.validation.datasets.catalogue import Entry, load
from tendond.offline.validation.datasets.poses import Poses, split_evenly
from tendond.offline.validation.evaluate import Request, evaluate
from tendond.offline.validation.results.report import as_json as plain
from tendond.offline.validation.results.report import header, lines, page, remarks
from tendond.offline.validation.rods.design import Design
from tendond.offline.validation.rods.known import straight

AUTO = ("auto",)
POSES = 600
"""Poses that the fit of a lab's own file goes through, about."""


def run_validate(
    dataset: str,
    data: str,
    groups: tuple[str, ...] | None,
    *,
    residual: bool,
    count: int | None,
    every: int | None,
    length: float | None,
    radius: float | None,
    out: Path | None,
    as_json: bool,
) -> bool:
    """Run a validation, see `tendond validate --help`; return whether the data set's target is met.

    Raises:
        DatasetError: data that are missing or cannot be read, or an unknown group of parameters.
        UsageError: a CSV file without the robot's sizes, or sizes of a robot that is known.
    """
    if out is not None:
        need("matplotlib")
    poses, entry = load(dataset, data)
    if every is not None:
        poses = split_evenly(poses, every)
    design = _design(poses, entry, length, radius)
    chosen = groups if groups is not None else AUTO if entry is None else entry.groups
    reach = float((poses.command.max(axis=0) - poses.command.min(axis=0)).max())
    near, apart = (entry.near, entry.apart) if entry is not None else (0.02 * reach, 10)
    through = count or (entry.poses if entry is not None else POSES)
    request = Request(None if chosen == AUTO else chosen, through, near, apart, residual)
    announce_compilation(say)
    with working(f"validating on {poses.name}", quiet=as_json) as status:
        found = evaluate(poses, design, request, lambda text: status.update(f"fitting {text}"))
    target = entry.target if entry is not None else None
    if as_json:
        print(json.dumps(plain(found, target), indent=2))
    else:
        print_table(Console(), header(), lines(found))
        print("\n".join(["", *remarks(found, target)]))
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        write_whole(out / f"{poses.name}.md", page(found, target))
        write_whole(out / f"{poses.name}.json", json.dumps(plain(found, target), indent=2) + "\n")
        if found.correction is not None:
            save(found.correction, out / f"{poses.name}-correction.json")
        from tendond.offline.validation.results.figure import draw

        draw(found, out / f"{poses.name}.png")
    return target is None or found.model("rod").held_out.rms <= target


def _design(poses: Poses, entry: Entry | None, length: float | None, radius: float | None) -> Design:
    """Return the design of the robot that was measured."""
    if entry is not None:
        if length is not None or radius is not None:
            raise UsageError(f"{poses.name}: its robot is known; --length and --radius are for a CSV file")
        return entry.design()
    if length is None or radius is None or length <= 0.0 or radius <= 0.0:
        raise UsageError(f"{poses.name}: give the robot's --length and --radius, both in metres and above 0")
    straightest = poses.tip[int(abs(poses.command).sum(axis=1).argmin())]
    base = (float(straightest[0]), float(straightest[1]), float(straightest[2]) - length)
    return straight(poses.tendons, length, radius, base)
