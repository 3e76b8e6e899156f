"""Contacts along the body that the filter found in a run: a table of them, and place and force over time."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.style import OURS
from tendond.schemas.record import ContactEstimate, CycleRecord

Array = NDArray[np.float64]

COLUMNS = ("found [s]", "to [s]", "place [mm]", "between [mm]", "force x, y, z [N]", "± [N]", "size [N]")


@dataclass(frozen=True)
class FoundContact:
    """A contact, from the cycle in which it was found to the last one that has it.

    Attributes:
        found, until: times of these cycles [s].
        last: what was known of it in the last one, with most of the data.
    """

    found: float
    until: float
    last: ContactEstimate

    @property
    def row(self) -> tuple[str, ...]:
        """Its cells under `COLUMNS`."""
        one = self.last
        return (
            f"{self.found:.3f}",
            f"{self.until:.3f}",
            f"{1e3 * one.place:.0f}",
            f"{1e3 * one.first_place:.0f} to {1e3 * one.last_place:.0f}",
            ", ".join(f"{part:.3f}" for part in one.force),
            ", ".join(f"{part:.3f}" for part in one.force_deviation),
            f"{math.hypot(*one.force):.3f}",
        )


def estimate_of(record: CycleRecord) -> ContactEstimate | None:
    """Return the contact that a cycle knows of, if there is one."""
    known = record.observer.filter
    return None if known is None else known.contact


def found_contacts(records: Iterable[CycleRecord]) -> list[FoundContact]:
    """Return the contacts of a run in their order: each a stretch of cycles that know of one."""
    contacts: list[FoundContact] = []
    before = False
    for record in records:
        known = estimate_of(record)
        if known is not None:
            found = contacts.pop().found if before else record.time
            contacts.append(FoundContact(found, record.time, known))
        before = known is not None
    return contacts


def draw_contacts(place: Axes, force: Axes, records: Sequence[CycleRecord], colours: Sequence[str]) -> None:
    """Draw place and force of contacts over time, with the places not excluded and bands of 2 sigma.

    Args:
        place, force: axes of the two.
        records: of a run. colours: of x, y and z.
    """
    time = np.array([record.time for record in records])
    known = [estimate_of(record) for record in records]
    places = _columns([None if one is None else (one.place, one.first_place, one.last_place) for one in known])
    place.fill_between(time, 1e3 * places[:, 1], 1e3 * places[:, 2], color=OURS, alpha=0.2)
    place.plot(time, 1e3 * places[:, 0], color=OURS)
    place.set(ylabel="place [mm]", title="Contact: place along the body, and those not excluded")
    forces = _columns([None if one is None else one.force for one in known])
    deviations = _columns([None if one is None else one.force_deviation for one in known])
    for i, colour in enumerate(colours):
        half = 2.0 * deviations[:, i]
        force.fill_between(time, forces[:, i] - half, forces[:, i] + half, color=colour, alpha=0.2)
        force.plot(time, forces[:, i], color=colour, label=f"{'xyz'[i]} ± 2σ")
    force.set(ylabel="force [N]", title="Contact: force")
    force.legend(loc="upper right", fontsize=appearance().points(9), ncols=3)


def _columns(rows: Sequence[tuple[float, float, float] | None]) -> Array:
    """Return rows as an array, shape (cycles, 3), NaN where there is none."""
    return np.array([(math.nan,) * 3 if row is None else row for row in rows])
