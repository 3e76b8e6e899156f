"""Contacts of a run in the figure and the report of its log."""

import dataclasses

import numpy as np
import pytest

from tendond.offline.logs.info import info
from tendond.offline.logs.log import LogFile, load
from tendond.offline.plots import report
from tendond.offline.plots.contacts import found_contacts
from tendond.offline.plots.filter import filter_figure
from tendond.offline.plots.report import page
from tendond.schemas.record import ContactEstimate, CycleRecord
from tests.unit.estimation.shown.conftest import Filtered

TOUCHED = ((30, 50), (80, 95))
"""Cycles with a contact: first, and after the last."""


def with_contact(record: CycleRecord, place: float) -> CycleRecord:
    found = ContactEstimate(
        place=place, first_place=place - 0.02, last_place=place + 0.05, force=(0.2, 0.0, -0.03),
        force_deviation=(0.011, 0.012, 0.4), statistic=50.0, onset=30.0, settled=False,
    )  # fmt: skip
    known = record.observer.filter
    assert known is not None
    observer = record.observer.model_copy(update={"filter": known.model_copy(update={"contact": found})})
    return record.model_copy(update={"observer": observer})


@pytest.fixture(scope="module")
def touched(filtered: Filtered) -> LogFile:
    """The run, with two contacts in its records; the place of each moves as data come."""
    log = load(filtered.path)
    records = list(log.records)
    for first, after in TOUCHED:
        for i in range(first, after):
            records[i] = with_contact(records[i], 0.2 + 1e-3 * i)
    return dataclasses.replace(log, records=records)


def test_each_stretch_is_a_contact_as_it_was_known_at_its_end(touched: LogFile) -> None:
    one, other = found_contacts(touched.records)
    assert (one.found, one.until) == (touched.records[30].time, touched.records[49].time)
    assert other.last.place == pytest.approx(0.294)
    assert one.row[2:] == ("249", "229 to 299", "0.200, 0.000, -0.030", "0.011, 0.012, 0.400", "0.202")


def test_the_figure_has_place_and_force_with_what_is_not_excluded(touched: LogFile, filtered: Filtered) -> None:
    axes = filter_figure(touched).axes
    assert len(axes) == len(filter_figure(load(filtered.path)).axes) + 2
    place, force = axes[3:]
    places = np.asarray(place.lines[0].get_ydata(), dtype=float)
    assert np.flatnonzero(np.isfinite(places)).tolist() == [*range(30, 50), *range(80, 95)]
    assert places[40] == pytest.approx(240.0)
    assert len(place.collections) == 1
    assert np.nanmax(np.asarray(force.lines[0].get_ydata(), dtype=float)) == pytest.approx(0.2)
    assert len(force.collections) == 3


def test_the_report_lists_them(touched: LogFile, filtered: Filtered, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report, "_image", lambda _, name: name)  # drawing takes seconds
    text = page(touched, info(filtered.path))
    assert text.index("<h2>Contacts</h2>") < text.index("229 to 299") < text.index("274 to 344")
    assert "<h2>Contacts</h2>" not in page(load(filtered.path), info(filtered.path))
