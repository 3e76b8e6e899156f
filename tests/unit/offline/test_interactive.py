"""The interactive page: it plays, everything is in view, legends are beside what they name."""

import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tendond.offline.logs.log import load
from tendond.offline.logs.paths import TipPath
from tendond.offline.plots.interactive import thinned, write_page
from tendond.offline.plots.player import MAX_FRAMES, box, frames_of, player
from tests.golden.scripts import FOLDER
from tests.unit.offline.browser import browse, browser

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"

LOOK = """<script>
requestAnimationFrame = drawn => setTimeout(() => drawn(performance.now()), 16);  // in the browser's virtual time
addEventListener("load", async () => {
  const wait = ms => new Promise(done => setTimeout(done, ms));
  await wait(500);
  const place = one => { const r = one.getBoundingClientRect(); return [r.left, r.top, r.right, r.bottom].join(","); };
  const legends = [...document.querySelectorAll("g.infolayer > g[class^=legend]")];
  document.body.setAttribute("data-legends", legends.map(place).join(";"));
  document.body.setAttribute("data-scene", place(document.querySelector("#space #scene")));
  const label = () => document.querySelector("#space .slider-label").textContent;
  const times = [label()];
  const [play, hold] = document.querySelectorAll("#space .updatemenu-button");
  play.dispatchEvent(new MouseEvent("click", {bubbles: true}));
  await wait(400);
  times.push(label());
  hold.dispatchEvent(new MouseEvent("click", {bubbles: true}));
  await wait(200);
  times.push(label());
  await wait(400);
  times.push(label());
  document.body.setAttribute("data-times", times.join(";"));
});
</script>"""
"""Notes where legends and scene are, plays, holds, and notes the selected time before, while, and twice after."""

TO_THE_END = """<script>
const frame = {duration: 0, redraw: true};
addEventListener("load", () => Plotly.animate("space", ["%s"], {frame, mode: "immediate"}));
</script>"""


def page_with(script: str, folder: Path) -> Path:
    """The page of a run, with a script before it."""
    page = write_page(load(NORMAL), folder / "run.html")
    plain = "<style>.modebar-container { display: none }</style>"  # its buttons lie over the scene
    page.write_text(page.read_text(encoding="utf-8").replace("<body>", f"<body>{plain}{script}"), encoding="utf-8")
    return page


def noted(dom: str, name: str) -> list[list[float]]:
    found = re.search(f'data-{name}="([^"]*)"', dom)
    assert found is not None
    return [[float(number) for number in re.findall(r"-?[\d.]+", one)] for one in found[1].split(";")]


@browser
def test_the_page_plays_and_holds_and_its_legends_do_not_overlap(tmp_path: Path) -> None:
    dom = browse(tmp_path, "--dump-dom", page_with(LOOK, tmp_path).as_uri())
    (start,), (playing,), (held,), (later,) = noted(dom, "times")
    assert start < playing
    assert held == later
    legends = noted(dom, "legends")
    assert len(legends) == 3  # of the scene, the tip, the tendons; the timing, which this run has not, has none
    for (left, top, right, bottom), other in combinations(legends, 2):
        assert right <= other[0] or other[2] <= left or bottom <= other[1] or other[3] <= top


@browser
@pytest.mark.parametrize("shown", ["first", "last"])
def test_the_whole_rod_is_in_view(shown: str, tmp_path: Path) -> None:
    """Nothing that is drawn reaches the edge of the scene."""
    last = frames_of(TipPath.of(load(NORMAL)))[-1].time
    page = page_with(LOOK, tmp_path)
    (left, top, right, bottom), *_ = noted(browse(tmp_path, "--dump-dom", page.as_uri()), "scene")
    page = page_with(TO_THE_END % f"{last:.2f}" if shown == "last" else "", tmp_path)
    browse(tmp_path, f"--screenshot={tmp_path / 'page.png'}", page.as_uri())
    picture = np.asarray(Image.open(tmp_path / "page.png").convert("L"))[round(top) : round(bottom)]
    across = slice(round(left + 0.2 * (right - left)), round(right))  # the legend is at the left
    dark = np.argwhere(picture[:, across] < 60)
    (highest, first), (lowest, final) = dark.min(axis=0), dark.max(axis=0)
    height, width = picture[:, across].shape
    assert len(dark) > 500
    assert 10 < highest < lowest < height - 10
    assert 10 < first < final < width - 10


@pytest.mark.parametrize("log", [NORMAL, FAULTS], ids=["normal", "faults"])
def test_the_axes_hold_everything_at_all_times_at_one_scale(log: Path) -> None:
    import plotly.graph_objects as go

    run = TipPath.of(load(log))
    figure = player(run, go)
    scene = figure.layout.scene
    ranges = np.array([scene.xaxis.range, scene.yaxis.range, scene.zaxis.range], float)
    ratio = np.array([scene.aspectratio.x, scene.aspectratio.y, scene.aspectratio.z])
    np.testing.assert_allclose(ratio / ratio[0], np.ptp(ranges, axis=1) / np.ptp(ranges[0]))
    drawn = [trace for frame in figure.frames for trace in frame.data] + list(figure.data)
    for i, letter in enumerate("xyz"):
        points = np.concatenate([np.asarray(trace[letter], float) for trace in drawn])
        assert ranges[i, 0] < np.nanmin(points)
        assert np.nanmax(points) < ranges[i, 1]
    assert run.target is not None
    assert (box(run)[0] < 1e3 * np.array(run.target)).all()


def test_a_long_run_is_played_at_equal_steps_of_time() -> None:
    run = TipPath.of(load(NORMAL))
    many = [run.shapes[0].__class__(tick, 0.05 * tick, run.shapes[0].points, ()) for tick in range(5000)]
    chosen = frames_of(TipPath(run.time, run.tip, run.reference, run.target, many))
    assert len(chosen) == MAX_FRAMES
    assert (chosen[0].tick, chosen[-1].tick) == (0, 4999)
    assert set(np.diff([shape.tick for shape in chosen])) <= {16, 17}


def test_a_thinned_curve_keeps_its_peaks_and_its_gaps() -> None:
    x = np.arange(100_000.0)
    y = np.sin(x / 1000.0)
    y[50_123], y[70_001:70_100] = 5.0, np.nan
    at, values = thinned(x, y, 1000)
    assert len(at) <= 1003
    assert np.nanmax(values) == 5.0
    assert at[np.nanargmax(values)] == 50_123.0
    assert np.isnan(values).any()
    assert (np.diff(at) > 0.0).all()
    assert thinned(x[:10], y[:10], 1000)[0] is not None
