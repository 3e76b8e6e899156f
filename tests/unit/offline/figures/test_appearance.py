"""Figures in the style of a journal: widths, fonts, text as text, lines that survive a grey print."""

import re
from itertools import pairwise
from pathlib import Path

import pytest
from matplotlib.colors import to_rgb
from matplotlib.text import Text

from tendond.daemon.errors import UsageError
from tendond.offline.logs.log import load
from tendond.offline.logs.metrics import tracking
from tendond.offline.plots.appearance import MM, STYLES, WIDE, Appearance, appearing, parse_formats
from tendond.offline.plots.output import Output
from tendond.offline.plots.panels import Panels
from tendond.offline.plots.style import LINES, line_look, new_figure, save, style
from tests.golden.scripts import FOLDER

NORMAL = FOLDER / "normal.mcap"


def drawn(folder: Path, look: Appearance, name: str = "tip_x") -> Path:
    """Draw a panel of the golden run."""
    log = load(NORMAL)
    with appearing(look), style():
        figure = new_figure(6.4, 4.0)
        Panels(log, tracking(log)).all[name](figure.subplots())
        return Output(folder).save(figure, name)[0]


@pytest.mark.parametrize(("name", "column", "page"), [("ieee", 88.9, 182.0), ("elsevier", 90.0, 190.0)])
def test_a_style_has_the_widths_of_its_journal(name: str, column: float, page: float) -> None:
    look = Appearance(name)
    assert look.size(6.4, 4.0)[0] == pytest.approx(column * MM)
    assert look.size(WIDE, 4.0)[0] == pytest.approx(page * MM)


def test_the_default_style_leaves_a_figure_as_it_was_drawn() -> None:
    assert Appearance().size(6.4, 4.0) == (6.4, 4.0)
    assert Appearance().points(9.0) == 9.0


def test_a_width_that_is_given_holds_for_every_figure(tmp_path: Path) -> None:
    svg = drawn(tmp_path, Appearance(formats=("svg",), width_mm=60.0)).read_text()
    width = re.search(r'width="([\d.]+)pt"', svg)
    assert width is not None
    assert float(width.group(1)) == pytest.approx(60.0 / 25.4 * 72.0, abs=0.1)


def test_text_is_text_in_svg_and_truetype_in_pdf(tmp_path: Path) -> None:
    svg = drawn(tmp_path, Appearance("ieee", ("svg",))).read_text()
    assert ">tip x [mm]</text>" in svg
    assert ">time [s]" in svg
    pdf = drawn(tmp_path, Appearance("ieee", ("pdf",))).read_bytes()
    assert b"/Subtype /Type3" not in pdf
    assert b"/FontFile2" in pdf or b"/CIDFontType2" in pdf


def test_every_format_that_is_asked_for_is_written(tmp_path: Path) -> None:
    drawn(tmp_path, Appearance(formats=("pdf", "svg", "png")))
    assert {path.name for path in tmp_path.iterdir()} == {"tip_x.pdf", "tip_x.svg", "tip_x.png"}
    with appearing(Appearance(formats=("svg", "pdf"))):
        assert save(new_figure(3.0, 2.0), tmp_path / "other.png") == tmp_path / "other.svg"
    assert (tmp_path / "other.pdf").exists()


def test_formats_are_one_or_several_of_those_known() -> None:
    assert parse_formats("pdf, SVG,pdf") == ("pdf", "svg")
    assert parse_formats("html", ("html",)) == ("html",)
    for wrong in ("gif", "", "png,tiff"):
        with pytest.raises(UsageError, match="choose one or several of png, pdf, svg"):
            parse_formats(wrong)


def test_the_axis_counts_iterations_only_on_request(tmp_path: Path) -> None:
    seconds = drawn(tmp_path, Appearance(formats=("svg",))).read_text()
    counted = drawn(tmp_path, Appearance(formats=("svg",), iterations=True)).read_text()
    assert "time [s]" in seconds
    assert "iteration" not in seconds
    assert "iteration" in counted
    assert "time [s]" not in counted


def test_a_font_that_is_not_installed_is_refused_with_those_that_are(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"'Nosuch' is not installed here; there are .*"):
        drawn(tmp_path, Appearance(font="Nosuch"))
    assert "STIXGeneral" in drawn(tmp_path, Appearance(formats=("svg",), font="STIXGeneral")).read_text()


def luminance(colour: str) -> float:
    """How bright a grey print of a colour is, from 0 to 1 (Rec. 709)."""
    red, green, blue = to_rgb(colour)
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def test_lines_differ_in_dashes_and_marker_and_neighbours_in_luminance() -> None:
    looks = [line_look(number, length=100) for number in range(len(LINES))]
    assert len({(str(look["ls"]), look["marker"]) for look in looks}) == len(LINES)
    first_four = sorted(luminance(colour) for colour, _, _ in LINES[:4])
    assert all(bright - dark > 0.09 for dark, bright in pairwise(first_four))
    assert all(abs(luminance(one[0]) - luminance(other[0])) > 0.09 for one, other in pairwise(LINES))


@pytest.mark.parametrize("name", STYLES)
def test_labels_of_a_panel_are_within_its_figure_and_do_not_meet(name: str) -> None:
    log = load(NORMAL)
    with appearing(Appearance(name)), style():
        figure = new_figure(6.4, 4.0)
        axes = figure.subplots()
        Panels(log, tracking(log)).all["tip_x"](axes)
        figure.draw_without_rendering()
        legend = axes.get_legend()
        assert legend is not None
        boxes = [legend.get_window_extent(), axes.get_window_extent(), axes.xaxis.label.get_window_extent()]
        heading = next((one for one in axes.findobj(Text) if one.get_text() == "x of the tip"), None)
        if heading is not None:
            boxes.append(heading.get_window_extent())
        assert all(not one.overlaps(other) for i, one in enumerate(boxes) for other in boxes[i + 1 :])
        assert all(figure.bbox.padded(1.0).contains(*corner) for box in boxes for corner in box.corners())
