"""The data sets by name, each with the design of its robot; anything else is the path of a CSV file."""

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from tendond.offline.validation.datasets import armlab, opencr, table
from tendond.offline.validation.datasets.poses import DatasetError, Poses
from tendond.offline.validation.rods import known
from tendond.offline.validation.rods.design import Design

VARIABLE = "TENDOND_REFERENCE_DATA"


@dataclass(frozen=True)
class Entry:
    """A public data set.

    Attributes:
        read: reads it from a folder of reference data. design: of its robot. target: RMS of held-out tips [m].
        near, apart: of pairs of poses that show what is repeatable, see `repeatability`.
        poses: that a fit goes through, about. groups: of parameters that are fitted.
    """

    read: Callable[[Path], Poses]
    design: Callable[[], Design]
    source: str
    target: float
    near: float
    apart: int
    poses: int
    groups: tuple[str, ...]


ENTRIES = {
    "armlab": Entry(
        armlab.read, known.armlab, armlab.SOURCE, 1.5e-3, 1.5e-4, 100, 800,
        ("tendon_stiffness", "axial_stiffness", "spool", "weight", "tip_weight", "marker", "angles", "radii"),
    ),
    "ftdcr_v4-tendon_pull": Entry(
        partial(opencr.read, version="ftdcr_v4", part="tendon_pull"), known.ftdcr_v4,
        opencr.SOURCE.format(version="ftdcr_v4"), 3e-3, 5e-4, 5, 600,
        ("tendon_stiffness", "section_stiffness", "yielding", "angles", "radii"),
    ),
    "ftdcr_v4-val": Entry(
        partial(opencr.read, version="ftdcr_v4", part="val"), known.ftdcr_v4,
        opencr.SOURCE.format(version="ftdcr_v4"), 4e-3, 1e-3, 10, 300,
        (
            "tendon_stiffness", "section_stiffness", "axial_stiffness", "weight", "precurvature", "friction",
            "yielding", "angles", "radii",
        ),
    ),
    "ftdcr_v6-val": Entry(
        partial(opencr.read, version="ftdcr_v6", part="val"), known.ftdcr_v6,
        opencr.SOURCE.format(version="ftdcr_v6"), 4e-3, 1e-3, 10, 300,
        ("tendon_stiffness", "section_stiffness", "yielding", "angles", "radii"),
    ),
}  # fmt: skip


def names() -> list[str]:
    """Return the names of the public data sets."""
    return list(ENTRIES)


def load(dataset: str, folder: str = "") -> tuple[Poses, Entry | None]:
    """Return the poses of a public data set, or of a CSV file.

    Args:
        dataset: a name, or a path.
        folder: of reference data; default: what TENDOND_REFERENCE_DATA names.

    Raises:
        DatasetError: there is no such data set, or its files are not there: where to get them.
    """
    entry = ENTRIES.get(dataset)
    if entry is None:
        path = Path(dataset)
        if not path.exists() and path.suffix:
            raise DatasetError(f"{dataset}: there is no such file")
        if not path.is_file():
            raise DatasetError(f"'{dataset}': is neither a CSV file nor one of {', '.join(ENTRIES)}")
        return table.read(path), None
    where = folder or os.environ.get(VARIABLE, "")
    if not where:
        raise DatasetError(
            f"{dataset}: no folder of public data: name it with --data, or set {VARIABLE}; get it from {entry.source}"
        )
    return entry.read(Path(where)), entry
