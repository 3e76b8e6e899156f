"""Drawing a run takes no longer than it must: nothing is imported for nothing, nothing is drawn twice."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy.interpolate import CubicSpline

from tendond.offline.plots.spline import smooth
from tendond.offline.plots.style import save, style
from tests.golden.scripts import FOLDER

NORMAL = FOLDER / "normal.mcap"
HEAVY = {"dask", "llvmlite", "numba", "pandas", "scipy", "tendond.model", "zenoh"}
"""Packages that take a tenth of a second or more to import, and draw nothing."""

LIST_IMPORTS = """
import sys
from tendond.cli import main
sys.argv = ["tendond", *sys.argv[1:]]
try:
    main()
finally:
    print("IMPORTED", *sys.modules, file=sys.stderr)
"""


@pytest.mark.parametrize("words", [["plot"], ["plot", "--format", "html"], ["log", "report"]], ids=" ".join)
def test_plots_and_reports_import_neither_the_model_nor_the_bus(words: list[str], tmp_path: Path) -> None:
    command = [sys.executable, "-c", LIST_IMPORTS, *words, str(NORMAL), "--out", str(tmp_path / "out")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert not HEAVY & set(result.stderr.split("IMPORTED ")[1].split())


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_saving_a_figure_draws_it_once(suffix: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn: list[Figure] = []
    draw = Figure.draw

    def noted(figure: Figure, renderer: Any) -> None:
        drawn.append(figure)
        draw(figure, renderer)

    monkeypatch.setattr(Figure, "draw", noted)
    with style():
        figure = Figure(layout="constrained")
        axes = figure.subplots()
        axes.set_ylabel("a label that needs its place")
        save(figure, tmp_path / f"figure.{suffix}")
    assert len(drawn) == 1
    assert axes.get_position().x0 > 0.05


def test_the_smooth_curve_is_the_natural_cubic_spline_through_its_points() -> None:
    """Reference: scipy's."""
    turn = np.linspace(0.0, 2.0, 9) ** 2
    points = np.column_stack([np.cos(turn), np.sin(turn), turn**2])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    curve = smooth(points)
    at = np.linspace(0.0, along[-1], len(curve))
    np.testing.assert_allclose(curve, CubicSpline(along, points, bc_type="natural")(at), atol=1e-12)
    np.testing.assert_allclose(curve[[0, -1]], points[[0, -1]], atol=1e-12)
    assert len(smooth(points[:2])) == 2
    assert len(smooth(points[[0, 1, 1, 2]])) == 4
