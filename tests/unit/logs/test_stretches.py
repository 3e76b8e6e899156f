"""A log shows itself: as text, and as a table in a notebook."""

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tendond.offline.logs import load
from tendond.offline.logs.stretches import POINTS, SPARKLINE, Stretch, sparkline, stretches
from tendond.schemas.messages import Mode
from tests.golden.scripts import FOLDER
from tests.unit.offline.records import cycle_record, write_log

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


def test_each_stretch_that_tracks_is_found_with_its_error() -> None:
    run = load(FAULTS)
    found = stretches(run)
    assert [(round(one.start, 2), len(one.error)) for one in found] == [(0.25, 70), (1.8, 2)]
    first = found[0]
    distance = np.linalg.norm(run["measured"] - run["reference.position"], axis=1)[25:95]
    np.testing.assert_array_equal(first.error, distance)
    assert (first.law, first.reference, round(first.duration, 6)) == ("backstepping", "exponential", 0.7)
    assert first.at_end == pytest.approx(distance[-20:].mean())
    assert first.largest == pytest.approx(distance.max())


def test_cycles_that_are_not_in_the_log_end_a_stretch(tmp_path: Path) -> None:
    records = [cycle_record(tick) for tick in (*range(10), *range(30, 35))]
    assert [len(one.error) for one in stretches(load(write_log(tmp_path / "gap.mcap", records)))] == [10, 5]


def test_the_text_of_a_log_is_a_line_for_each_stretch() -> None:
    heading, *lines = repr(load(FAULTS)).splitlines()
    assert heading == "faults.mcap: rig 'paper', 190 cycles, 1.90 s"
    assert [line.split(",")[0] for line in lines] == [
        "  tracking: from 0.25 s for 0.70 s",
        "  tracking: from 1.80 s for 0.02 s",
    ]


def test_a_notebook_shows_a_row_and_a_curve_for_each_stretch() -> None:
    page = ElementTree.fromstring(load(FAULTS)._repr_html_())
    rows = page.findall(".//tbody/tr")
    assert [[cell.text for cell in row][:4] for row in rows] == [
        ["0.25", "0.70", "backstepping", "exponential"],
        ["1.80", "0.02", "backstepping", "exponential"],
    ]
    line = rows[0].find(".//polyline")
    assert line is not None
    points = line.get("points", "").split()
    x, y = np.array([point.split(",") for point in points], float).T
    assert len(points) == 70
    assert (np.diff(x) > 0.0).all()
    assert (y >= 0.0).all()
    assert (y <= SPARKLINE[1]).all()
    assert y[np.argmax(stretches(load(FAULTS))[0].error)] == y.min() < y[-1] < y[0]  # the largest error is at the top


def test_a_log_that_never_tracks_or_has_no_tip_shows_itself_too(tmp_path: Path) -> None:
    idle = load(write_log(tmp_path / "idle.mcap", [cycle_record(tick, mode=Mode.IDLE) for tick in range(5)]))
    assert "never tracked" in idle._repr_html_()
    assert repr(idle).endswith("never tracking")
    blind = load(write_log(tmp_path / "blind.mcap", [cycle_record(tick, measured=None) for tick in range(5)]))
    (one,) = stretches(blind)
    assert np.isnan(one.at_end)
    assert "<td>-</td>" in blind._repr_html_()


def test_a_name_cannot_put_markup_into_the_page() -> None:
    run = load(NORMAL)
    rig = run.config.rig.model_copy(update={"name": "<b>"})
    page = replace(run, config=run.config.model_copy(update={"rig": rig}))._repr_html_()
    assert "<b>" not in page
    assert "&lt;b&gt;" in page


def test_a_curve_of_many_cycles_has_a_limited_number_of_points_and_keeps_its_peaks() -> None:
    error = np.full(100_000, 1e-4)
    error[50_000] = 0.1
    points = sparkline(Stretch(0.0, 1000.0, "", "", error)).split('points="')[1].split('"')[0].split()
    assert len(points) == POINTS
    assert min(float(point.split(",")[1]) for point in points) == pytest.approx(2.0)
