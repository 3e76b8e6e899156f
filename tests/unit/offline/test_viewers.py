"""The tools that people use: mcap's own checks, Rerun, Foxglove's protocol, the example of the Python API."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.recording import scene
from tendond.offline.logs.log import load
from tendond.offline.logs.paths import TipPath
from tendond.offline.logs.run import open_run
from tendond.offline.replay.offline import record_lockstep
from tendond.schemas.config.rig import check_config
from tendond.schemas.requests import ControlAction
from tests.golden.scripts import FOLDER

ROOT = Path(__file__).parents[3]
NORMAL = FOLDER / "normal.mcap"
RERUN = shutil.which("rerun", path=f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}")


def test_the_file_passes_the_mcap_librarys_own_checks() -> None:
    with NORMAL.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        messages = list(reader.iter_messages())
        assert len(messages) == summary.statistics.message_count
        assert {schema.name for schema, _, _ in messages if schema is not None} >= {
            *("foxglove.PoseInFrame", "foxglove.FrameTransforms", "foxglove.SceneUpdate", "tendond.CycleRecord")
        }
        for _, channel, message in messages:
            if channel.topic == "tf":
                frames = {frame["child_frame_id"] for frame in json.loads(message.data)["transforms"]}
                assert frames <= {"tip_model", "tip_measured"}
        scene = next(json.loads(message.data) for _, channel, message in messages if channel.topic == "rod/shape")
        assert len(scene["entities"][0]["lines"]) == 1 + 4  # rod and tendons


def test_the_scene_has_a_target_and_a_trail_of_the_tip_that_does_not_grow_for_ever(tmp_path: Path) -> None:
    """A log in space: lockstep writes a push out of the plane."""
    impact = {"time": 0.6, "duration": 0.05, "force": (0.0, 2.0, 0.0)}
    tables = {"simulator": {"impacts": [impact]}, "log": {"shape_period": 2}, "commissioning": {"probe": False}}
    config = check_config(tables, "test")
    path = tmp_path / "space.mcap"
    setup = CycleSetup.from_config(config)
    records = record_lockstep(setup, 160, {5: ControlAction.ARM}, path)
    scenes = [json.loads(message.data)["entities"] for _, message in open_run(path).messages(("rod/shape",))]
    trails = [[tuple(point.values()) for point in trail["lines"][0]["points"]] for _, trail in scenes]
    assert [len(trail) for trail in trails] == [min(i + 1, scene.TRAIL_POINTS) for i in range(len(trails))]
    measured = [record.measured or record.model.position for record in records[::2]]
    np.testing.assert_allclose(trails[-1], measured[-scene.TRAIL_POINTS :], atol=0.6e-4)
    assert max(abs(point[1]) for point in trails[-1]) > 0.02
    for (rod, trail), record in zip(scenes, records[::2], strict=True):
        assert (rod["id"], trail["id"]) == ("rod", "trail")
        assert tuple(rod["spheres"][1]["pose"]["position"].values()) == record.reference.position
    assert TipPath.of(load(path)).view == (22.0, -55.0)


@pytest.mark.skipif(RERUN is None, reason="needs rerun-sdk")
def test_rerun_finds_nothing_wrong_with_a_log_and_loads_it(tmp_path: Path) -> None:
    assert RERUN is not None
    environment = {**os.environ, "HOME": str(tmp_path), "NO_COLOR": "1"}
    check = subprocess.run(
        [RERUN, "mcap", "check", str(NORMAL)], capture_output=True, text=True, timeout=60, env=environment
    )
    assert check.returncode == 0, check.stderr
    rows = re.findall(r"^(\S+)\s+\d+\s+\d+\s+(\S+)", check.stdout, re.MULTILINE)
    assert {topic for status, topic in rows if status == "ok"} >= {"cycle", "rod/shape", "tip/model", "tf"}
    assert all(status == "ok" for status, _ in rows)
    out = tmp_path / "log.rrd"
    subprocess.run(
        [RERUN, "mcap", "convert", str(NORMAL), "-o", str(out)], capture_output=True, timeout=60, check=True,
        env=environment,
    )  # fmt: skip
    assert out.stat().st_size > 10_000


@pytest.mark.skipif(RERUN is None, reason="needs rerun-sdk")
def test_the_rerun_recipe_makes_curves_and_shapes(tmp_path: Path) -> None:
    assert RERUN is not None
    out = tmp_path / "run.rrd"
    environment = {**os.environ, "HOME": str(tmp_path), "NO_COLOR": "1"}
    recipe = [sys.executable, str(ROOT / "deploy" / "rerun" / "log_to_rerun.py"), str(NORMAL), "--save", str(out)]
    subprocess.run(recipe, capture_output=True, timeout=60, check=True, env=environment)
    stats = subprocess.run(
        [RERUN, "rrd", "stats", str(out)], capture_output=True, text=True, timeout=60, check=True, env=environment
    )
    for entity in (
        "/rod",
        "/tendons",
        "/tip",
        "/trail",
        "/reference",
        "/target",
        "/numbers/command/displacement/0",
        "/numbers/model/residual",
    ):
        assert f"{entity}:" in stats.stdout, entity


def test_the_rerun_recipe_says_at_once_that_there_is_no_display() -> None:
    pytest.importorskip("rerun")
    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    recipe = [sys.executable, str(ROOT / "deploy" / "rerun" / "log_to_rerun.py"), str(NORMAL)]
    result = subprocess.run(recipe, capture_output=True, text=True, timeout=60, env=environment)
    assert result.returncode == 2
    last = result.stderr.splitlines()[-1]
    assert "no display" in last
    assert "--save" in last
    assert "--serve" in last


def test_the_example_runs() -> None:
    example = [sys.executable, str(ROOT / "examples" / "analyse_log.py"), str(NORMAL)]
    result = subprocess.run(example, capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr
    assert "command.displacement: shape (190, 4), unit m" in result.stdout


EXAMPLES = sorted(path for path in (ROOT / "examples").glob("*.py") if path.name != "analyse_log.py")


def test_the_gallery_has_each_example_with_its_picture() -> None:
    text = (ROOT / "docs" / "gallery.md").read_text(encoding="utf-8")
    assert re.findall(r"\]\(\.\./examples/(\w+)\.py\), run as", text) == re.findall(r"images/gallery-(\w+)\.png", text)
    assert sorted(re.findall(r"images/gallery-(\w+)\.png", text)) == [path.stem for path in EXAMPLES]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_draws_its_picture(example: Path, tmp_path: Path) -> None:
    command = [sys.executable, str(example), str(tmp_path / "picture.png")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    assert len(list(tmp_path.iterdir())) == 1
