"""The figure of the rod's shapes shows gravity, as far down the page as the plane of bending allows."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.text import Annotation

from tendond.offline.logs.log import LogFile, load
from tendond.offline.plots.figures import shapes_figure
from tests.golden.scripts import FOLDER


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
