"""`log animate`: pictures that move, in each format, with what a rig lacks named in a line."""

import os
import stat
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from tendond.offline.logs.log import load
from tendond.offline.logs.metrics import runs
from tendond.offline.movies.motion import arrow, held_force
from tendond.offline.movies.scene import Scene
from tests.golden.scripts import FOLDER
from tests.unit.logs.commands import run_command
from tests.unit.offline.figures.logs import approach, idle, write_simulated
from tests.unit.offline.records import write_log

NORMAL = FOLDER / "normal.mcap"
SHORT = ("--to", "0.5", "--fps", "10", "--width", "300")


@pytest.mark.parametrize(("form", "kind"), [("gif", "GIF"), ("apng", "PNG")])
def test_a_movie_has_a_picture_for_each_moment(tmp_path: Path, form: str, kind: str) -> None:
    out = tmp_path / f"run.{form}"
    result = run_command("animate", str(NORMAL), "--out", str(out), *SHORT)
    assert result.returncode == 0, result.stderr
    with Image.open(out) as movie:
        assert (movie.format, getattr(movie, "n_frames", 1), movie.size) == (kind, 6, (300, 168))
        assert movie.info["duration"] == pytest.approx(100)
    assert f"{out}: 6 pictures" in result.stdout


def test_the_rod_moves_and_the_axes_do_not() -> None:
    log = load(NORMAL)
    scene = Scene(log, runs(log)[0], 600, (0.0, 1.0))
    one, other, again = scene.picture(0.0), scene.picture(0.3), scene.picture(0.0)
    assert one.shape == (336, 600, 3)
    np.testing.assert_array_equal(one, again)
    left = slice(60, None), slice(0, 330)
    assert (one[left] != other[left]).any(axis=2).sum() > 200
    changed = (one != other).any(axis=2)
    assert not changed[-12:].any()  # the labels below


def test_several_formats_are_written_beside_the_log_and_runs_have_names_of_their_own(tmp_path: Path) -> None:
    log = write_log(tmp_path / "two.mcap", approach(0, 40) + idle(40, 10) + approach(50, 40))
    for number in ("1", "2"):
        result = run_command("log", "animate", str(log), "--format", "gif,apng", "--run", number, *SHORT)
        assert result.returncode == 0, result.stderr
    assert {path.name for path in tmp_path.iterdir() if path.suffix != ".sha256"} == {
        *("two.mcap", "two.gif", "two.apng", "two-run2.gif", "two-run2.apng")
    }
    again = run_command("animate", str(log), *SHORT)
    assert again.returncode == 1
    assert "exists already; --force" in again.stderr
    missing = run_command("animate", str(log), "--run", "3", *SHORT)
    assert (missing.returncode, "has 2 runs; choose --run 1 to 2" in missing.stderr) == (2, True)


def test_a_pipe_gets_progress_as_lines(tmp_path: Path) -> None:
    result = run_command("animate", str(NORMAL), "--out", str(tmp_path / "a.gif"), "--to", "0.7", *SHORT[2:])
    assert [line for line in result.stderr.splitlines() if "pictures" in line] == [
        "tendond: 2 of 8 pictures",
        "tendond: 4 of 8 pictures",
        "tendond: 6 of 8 pictures",
    ]


def test_mp4_without_ffmpeg_is_refused_with_the_remedy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    result = run_command("animate", str(NORMAL), "--out", str(tmp_path / "run.mp4"))
    assert result.returncode == 2
    assert result.stderr == (
        "tendond: MP4 needs ffmpeg, which is not installed: apt install ffmpeg, or take --format gif\n"
    )
    assert list(tmp_path.iterdir()) == []


def fake_ffmpeg(folder: Path, script: str) -> None:
    """Put a program named ffmpeg into a folder."""
    program = folder / "ffmpeg"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)


def test_ffmpeg_gets_every_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_ffmpeg(tmp_path, 'for last; do :; done; wc -c > "$last"')
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    out = tmp_path / "run.mp4"
    result = run_command("animate", str(NORMAL), "--out", str(out), *SHORT)
    assert result.returncode == 0, result.stderr
    assert int(out.read_text()) == 6 * 300 * 168 * 3


def test_the_reason_of_ffmpeg_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fake_ffmpeg(tmp_path, "echo 'Unknown encoder' >&2; exit 1")
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    result = run_command("animate", str(NORMAL), "--out", str(tmp_path / "run.mp4"), *SHORT)
    assert result.returncode == 1
    assert "ffmpeg failed: Unknown encoder; --format gif needs no ffmpeg" in result.stderr


def test_another_ending_is_refused(tmp_path: Path) -> None:
    result = run_command("animate", str(NORMAL), "--out", str(tmp_path / "run.avi"))
    assert result.returncode == 2
    assert "end its name in .gif, .mp4, .apng" in result.stderr


def test_a_cycle_without_truth_keeps_the_force_of_the_one_before(tmp_path: Path) -> None:
    log = load(write_simulated(tmp_path / "a.mcap", approach(0, 30)))
    pushed = replace(log, truth=[one.model_copy(update={"tip_force": (float(one.seq), 0.0, 0.0)}) for one in log.truth])
    sparse = replace(pushed, truth=pushed.truth[::3], truth_ticks=pushed.truth_ticks[::3])
    assert [force[0] for force in held_force(sparse, np.arange(7))] == [0.0, 0.0, 0.0, 3.0, 3.0, 3.0, 6.0]


@pytest.mark.parametrize("along", [(1.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, -3.0), (1.0, 1.0, 1.0)])
def test_an_arrow_ends_where_its_force_does_and_its_head_is_behind(along: tuple[float, float, float]) -> None:
    points = arrow(np.zeros(3), np.array(along), 0.2, across=1)
    end, direction = points[1], np.array(along) / np.linalg.norm(along)
    np.testing.assert_allclose(end, along)
    for tip in (points[2], points[4]):
        assert (tip - end) @ direction == pytest.approx(-0.2)
        assert np.linalg.norm(np.cross(tip - end, direction)) == pytest.approx(0.1)
