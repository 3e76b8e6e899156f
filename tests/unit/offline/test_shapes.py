"""The figure of the rod's shapes shows gravity, as far down the page as the plane of bending allows."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Annotation

from tendond.offline.logs.info import info
from tendond.offline.logs.log import LogFile, load
from tendond.offline.plots.figures import shapes_figure
from tendond.offline.plots.report import page
from tests.golden.scripts import FOLDER
from tests.unit.offline.records import cycle_record, write_log


def with_gravity(log: LogFile, *gravity: float) -> LogFile:
    rod = log.config.rod.model_copy(update={"gravity": gravity})
    return replace(log, config=log.config.model_copy(update={"rod": rod}))


@pytest.mark.parametrize(
    ("gravity", "right", "up"),
    [
        ((-9.81, 0.0, 0.0), "z [mm]", "x [mm]"),
        ((0.0, 0.0, -9.81), "x [mm]", "z [mm]"),
        ((0.0, 0.0, 0.0), "x [mm]", "z [mm]"),
    ],
)
def test_gravity_points_down_the_page(gravity: tuple[float, float, float], right: str, up: str) -> None:
    figure = shapes_figure(with_gravity(load(FOLDER / "normal.mcap"), *gravity))
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (right, up)
    figure.draw_without_rendering()
    arrows = [one.arrow_patch for one in axes.texts if isinstance(one, Annotation) and one.arrow_patch is not None]
    assert len(arrows) == (1 if any(gravity) else 0)
    for arrow in arrows:
        (left, top), (end, bottom) = np.asarray(arrow.get_path().vertices)[[0, -1]]
        assert top > bottom
        assert abs(end - left) < 0.1 * (top - bottom)


@pytest.mark.parametrize(
    ("degrees", "label", "title"),
    [
        (0.0, "x [mm]", "Rod while it moves"),
        (90.0, "y [mm]", "Rod while it moves"),
        (-90.0, "y [mm]", "Rod while it moves"),
        (30.0, "across [mm]", "Rod while it moves (across: 30° from x towards y)"),
        (120.0, "across [mm]", "Rod while it moves (across: 120° from x towards y)"),
        (240.0, "across [mm]", "Rod while it moves (across: 60° from x towards y)"),
    ],
)
def test_a_run_is_seen_from_the_side_of_its_motion(degrees: float, label: str, title: str, tmp_path: Path) -> None:
    x, y = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    places = [(part * x, part * y, math.sqrt(0.25 - part**2)) for part in np.linspace(0.0, 0.2, 30)]
    log = load(write_log(tmp_path / "a.mcap", [cycle_record(i, at, target=places[-1]) for i, at in enumerate(places)]))
    axes = shapes_figure(with_gravity(log, 0.0, 0.0, 0.0)).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel(), axes.get_title(loc="left")) == (label, "z [mm]", title)
    path = next(line for line in axes.lines if line.get_label() == "path of the tip")
    assert np.ptp(np.asarray(path.get_xdata(), dtype=float)) == pytest.approx(200.0, rel=0.01)


def test_a_rod_that_stays_straight_has_room_on_both_sides(tmp_path: Path) -> None:
    places = [(2e-4 * i, 0.0, 0.5) for i in range(30)]
    log = load(write_log(tmp_path / "a.mcap", [cycle_record(i, at, target=places[-1]) for i, at in enumerate(places)]))
    low, high = shapes_figure(log).axes[0].get_ylim()  # x: this rod is level
    assert high - low >= 0.29e3 * log.config.rod.backbone_length


def test_a_report_shows_a_run_to_the_side_that_has_no_metrics(tmp_path: Path) -> None:
    places = [(0.0, 0.005 * i, 0.45) for i in range(30)]
    file = write_log(tmp_path / "a.mcap", [cycle_record(i, at, target=places[-1]) for i, at in enumerate(places)])
    text = page(load(file), info(file))
    assert "the tip goes nowhere in x" in text
    assert 'alt="Tracking"' in text
    assert 'alt="Rod shapes"' in text
