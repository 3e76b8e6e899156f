"""Figures and pages of a run, looked at by a browser without network."""

import base64
import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from tendond.offline.logs.events import FAULT, MODE, REJECTED, REQUEST, events, mode_spans, tallies
from tendond.offline.logs.log import load
from tendond.offline.logs.metrics import runs
from tendond.offline.logs.paths import TipPath
from tendond.offline.logs.summary import LABELS, summary
from tendond.offline.plots.figures import NAMES
from tendond.offline.plots.interactive import write_page
from tendond.offline.plots.output import Output
from tendond.offline.plots.report import write_report
from tendond.offline.plots.spatial import space_figures
from tests.golden.scripts import CYCLES, FOLDER
from tests.unit.logs.commands import run_command
from tests.unit.offline.browser import browse, browser
from tests.unit.offline.records import cycle_record, write_log

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"
LOOK = """<script>
addEventListener("load", async () => {
  const images = [];
  for (const image of document.images) {
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
    const pen = canvas.getContext("2d");
    pen.drawImage(image, 0, 0);
    const data = pen.getImageData(0, 0, canvas.width, canvas.height).data;
    const colours = new Set();
    for (let i = 0; i < data.length; i += 4)
      if (data[i + 3]) colours.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
    images.push(`${image.alt}:${Math.round(image.getBoundingClientRect().width)}:${colours.size}`);
  }
  document.body.setAttribute("data-images", images.join(";"));
});
</script>"""
"""Draws every figure of a page onto a canvas and notes its width on the page and its number of colours."""


def fetched(page: str) -> list[str]:
    """List what a page would request from a network."""
    tags = re.findall(r"<(?:script|link|img|iframe|object|source)\b[^>]*?\b(?:src|href|data)=[\"']?([^\"'\s>]+)", page)
    return [address for address in tags if not address.startswith("data:")] + re.findall(r"@import|url\(http", page)


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_report(FAULTS, tmp_path_factory.mktemp("report") / "faults.html")


def test_a_report_has_numbers_faults_configuration_and_versions_and_fetches_nothing(report: Path) -> None:
    page = report.read_text(encoding="utf-8")
    assert fetched(page) == []
    assert "<script" not in page
    for text in (
        "tpl_mm",
        "total path length",
        "pose stale: none accepted for 0.21 s",
        "servo 2: overload",
        "limits.tension_max",
        "numba",
    ):
        assert text in page, text
    assert re.search(r"<td>limits.release_rate</td><td>200.0</td><td>60.0</td>", page)
    assert page.count("data:image/svg+xml;base64,") == 4


def test_the_figures_of_a_report_are_pictures_with_curves(report: Path) -> None:
    codes = re.findall(r"base64,([A-Za-z0-9+/=]+)", report.read_text(encoding="utf-8"))
    pictures = [base64.b64decode(code).decode() for code in codes]
    assert all(picture.count("<path") > 30 for picture in pictures)


@browser
def test_a_browser_draws_every_figure_of_a_report(report: Path, tmp_path: Path) -> None:
    looking = tmp_path / "looking.html"
    looking.write_text(report.read_text(encoding="utf-8").replace("</body>", LOOK + "</body>"), encoding="utf-8")
    found = re.search(r'data-images="([^"]*)"', browse(tmp_path, "--dump-dom", looking.as_uri()))
    assert found is not None
    images = {
        name: (int(width), int(colours)) for name, width, colours in (one.split(":") for one in found[1].split(";"))
    }
    assert set(images) == {"Tracking", "Rod shapes", "In space", "Modes and events"}
    assert all(width > 300 and colours > 20 for width, colours in images.values()), images


@browser
def test_a_report_prints_on_a_few_pages_of_a4(report: Path, tmp_path: Path) -> None:
    printed = tmp_path / "report.pdf"
    browse(tmp_path, f"--print-to-pdf={printed}", "--no-pdf-header-footer", report.as_uri())
    data = printed.read_bytes()
    boxes = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", data)
    assert 4 <= len(boxes) <= 14
    assert {(round(float(width)), round(float(height))) for width, height in boxes} <= {
        (595, 842),
        (596, 842),
        (594, 841),
    }


@browser
def test_the_interactive_page_draws_its_curves_without_network(tmp_path: Path) -> None:
    page = write_page(load(FAULTS), tmp_path / "run.html")
    assert not re.search(r"<(script|link)[^>]*(src|href)=", page.read_text(encoding="utf-8").split("<body>")[1][:5000])
    dom = browse(tmp_path, "--dump-dom", page.as_uri())
    lines = re.findall(r'<path class="js-line"[^>]* d="(M[^"]*)"', dom)
    assert len(lines) >= 12
    assert max(len(line) for line in lines) > 500
    assert dom.count('class="legendtext"') == 11  # an entry a curve; a tendon's is for both of its curves


def test_plot_writes_png_svg_or_html(tmp_path: Path) -> None:
    figures = len(runs(load(FAULTS))) * (len(NAMES) + 1) + 1  # and space; timeline
    for form, count in (("svg", figures), ("html", 1)):
        result = run_command("plot", str(FAULTS), "--out", str(tmp_path / form), "--format", form)
        assert result.returncode == 0, result.stderr
        files = [Path(line) for line in result.stdout.split()]
        assert len(files) == len(list((tmp_path / form).iterdir())) == count
        assert all(file.suffix == f".{form}" and file.stat().st_size > 5000 for file in files)
    assert run_command("plot", str(FAULTS), "--format", "gif").returncode == 2


def test_a_run_that_never_tracks_is_plotted_and_reported_too(tmp_path: Path) -> None:
    from tendond.schemas.messages import Mode

    path = write_log(tmp_path / "idle.mcap", [cycle_record(tick, mode=Mode.IDLE) for tick in range(20)])
    result = run_command("plot", str(path))
    assert result.returncode == 0, result.stderr
    assert "contains no cycle in mode 'tracking'" in result.stderr
    assert {file.name for file in (tmp_path / "idle-plots").iterdir()} == {
        *("idle-space.png", "idle-timeline.png", "idle-timing.png")
    }
    page = write_report(path, tmp_path / "idle.html").read_text(encoding="utf-8")
    assert "contains no cycle in mode" in page
    assert 'alt="Loop timing"' in page


def test_events_are_those_of_the_run() -> None:
    records = load(FAULTS).records
    found = events(records)
    assert [event.tick for event in found if event.kind == FAULT] == [95, 182]
    assert [event.tick for event in found if event.kind == REQUEST] == [5, 70, 125, 160]
    assert [event.text for event in found if event.kind == REJECTED][:2] == ["occluded", "occluded"]
    assert [event.tick for event in found if event.kind == MODE][:3] == [0, 5, 25]
    spans = mode_spans(records)
    assert (spans[0][0], spans[-1][1]) == (0.0, records[-1].time)
    assert all(before[1] == after[0] for before, after in pairwise(spans))


def test_compare_puts_all_metrics_of_runs_beside_each_other(tmp_path: Path) -> None:
    result = run_command("log", "compare", str(NORMAL), str(FAULTS), "--out", str(tmp_path))
    assert result.returncode == 0, result.stderr
    lines = (tmp_path / "metrics.csv").read_text().splitlines()
    assert lines[0] == "metric,unit,normal,faults run 1,faults run 2"
    names = [line.split(",")[0] for line in lines[1:]]
    assert {"tpl_mm", "settling_s", "path_overshoot_percent", "peak_tension_n", "final_tip_x_m"} <= set(names)
    assert all(line.count(",") == lines[0].count(",") for line in lines)
    assert (tmp_path / "compare.png").read_bytes().startswith(b"\x89PNG")
    assert CYCLES > 100


def test_a_path_in_a_plane_is_drawn_from_its_side_and_one_in_space_from_a_corner(tmp_path: Path) -> None:
    flat = TipPath.of(load(NORMAL))
    assert flat.view == pytest.approx((12.0, -72.0), abs=4.0)
    assert flat.target == pytest.approx((0.34, 0.0, 0.0475), abs=1e-3)
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    circle = [(0.2 * np.cos(a), 0.2 * np.sin(a), 0.45) for a in turn]
    log = load(write_log(tmp_path / "circle.mcap", [cycle_record(i, place) for i, place in enumerate(circle)]))
    path = TipPath.of(log)
    assert path.view == (22.0, -55.0)
    np.testing.assert_allclose(path.tip, circle)
    assert len(path.chosen(5)) <= 6
    assert {0, len(path.shapes) - 1} <= set(path.chosen(5))
    other = [(0.0, 0.2 * np.sin(a / 4), 0.5 * np.cos(a / 4)) for a in turn]
    records = [cycle_record(i, place, target=(0.0, 0.2, 0.3)) for i, place in enumerate(other)]
    elevation, azimuth = TipPath.of(load(write_log(tmp_path / "yz.mcap", records))).view
    assert (elevation, abs(azimuth - 18.0) < 1.0) == (12.0, True)
    assert Output(tmp_path).draw(space_figures(log))[0].stat().st_size > 20_000


def test_what_is_out_of_the_ordinary_is_counted() -> None:
    found = {(one.kind, one.text): one for one in tallies(events(load(FAULTS).records))}
    assert found[REJECTED, "occluded"].cycles == 2
    assert found[REJECTED, "occluded"].stretches == 2
    assert (found["no new pose", ""].cycles, found["no new pose", ""].longest) == (30, 25)


def test_every_number_of_a_summary_has_a_name_for_people() -> None:
    assert set(summary(load(NORMAL))) - {"recoveries"} == set(LABELS)  # a recovery has a name of its own
