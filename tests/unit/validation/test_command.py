"""`tendond validate` on a lab's own file, and, where TENDOND_REFERENCE_DATA names them, on others' data."""

import json
import os
from pathlib import Path

import numpy as np
import pytest

from tendond.offline.validation.datasets import armlab, opencr
from tendond.offline.validation.datasets.poses import thinned
from tendond.offline.validation.fitting.problem import staged
from tendond.offline.validation.results.metrics import errors_of
from tendond.offline.validation.rods import known
from tendond.offline.validation.rods.build import build
from tendond.offline.validation.rods.parameters import defaults, parameters_of
from tendond.offline.validation.rods.predict import predict
from tests.unit.cli.commands import tendond
from tests.unit.validation.robots import simulated

DATA = os.environ.get("TENDOND_REFERENCE_DATA", "")


def public(*below: str) -> pytest.MarkDecorator:
    """Skip a test of others' data, which no copy of this project holds, where they have not been fetched; say which."""
    path = Path(DATA, *below)
    missing = f"{path} is not there" if DATA else "TENDOND_REFERENCE_DATA names no folder of others' data"
    return pytest.mark.skipif(not DATA or not path.exists(), reason=f"{missing}: see docs/evidence.md")


def written(folder: Path) -> Path:
    """Write a simulated robot's poses as a lab's own file."""
    poses = simulated(noise=1e-5, yielding=0.6, yield_curvature=0.4)
    rows = np.hstack([poses.command, poses.tip, poses.block[:, None]])
    file = folder / "mine.csv"
    file.write_text(
        "displacement_0,displacement_1,displacement_2,x,y,z,block\n"
        + "".join(",".join([*(repr(float(cell)) for cell in row[:-1]), str(int(row[-1]))]) + "\n" for row in rows)
    )
    return file


def test_a_missing_data_set_is_answered_with_the_names_of_those_that_there_are(
    capsys: pytest.CaptureFixture[str],
) -> None:
    ended = tendond(capsys, "validate")
    assert ended.status == 2
    assert "DATASET is missing: name armlab, ftdcr_v4-tendon_pull," in ended.said


def test_a_labs_own_robot_is_validated_with_report_and_correction(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    pytest.importorskip("matplotlib")
    given = (
        "--length",
        "0.2",
        "--radius",
        "0.008",
        "--parameters",
        "yielding",
        "--residual",
        "--json",
    )
    ended = tendond(capsys, "validate", str(written(tmp_path)), *given, "--out", str(tmp_path / "out"))
    assert ended.status == 0
    found = json.loads(ended.out)
    errors = {name: one["held_out"]["rms"] for name, one in found["models"].items()}
    assert errors["rod"] < 1e-4 < errors["rod without friction"] < errors["constant curvature"]
    assert {one.name for one in (tmp_path / "out").iterdir()} == {
        "mine.md", "mine.json", "mine.png", "mine-correction.json",
    }  # fmt: skip
    assert "| rod | " in (tmp_path / "out" / "mine.md").read_text()


@pytest.mark.parametrize(
    ("more", "status", "said"),
    [
        ((), 2, "--length and --radius"),
        (("--length", "0.2", "--radius", "0.008", "--parameters", "gearbox"), 1, "no group of parameters 'gearbox'"),
    ],
)
def test_what_is_missing_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, more: tuple[str, ...], status: int, said: str
) -> None:
    ended = tendond(capsys, "validate", str(written(tmp_path)), *more)
    assert (ended.status, said in ended.said) == (status, True)


def test_a_data_set_that_is_unknown_or_missing_is_an_error_with_its_source(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("TENDOND_REFERENCE_DATA", raising=False)
    ended = tendond(capsys, "validate", "armlab")
    assert ended.status == 1
    assert "github.com/ARM-Lab" in ended.said
    ended = tendond(capsys, "validate", "nothing")
    assert ended.status == 1
    assert "armlab, ftdcr_v4-tendon_pull" in ended.said


@public(armlab.FILE)
def test_armlabs_tips_are_within_three_millimetres_by_few_parameters() -> None:
    design, poses = known.armlab(), thinned(armlab.read(Path(DATA)), 150, turning=False)
    base = {**defaults(parameters_of(design)), **design.start}
    values, _, _ = staged(design, poses, [("pose", "radius", "zeros")], base)
    tips = predict(build(design, values), poses.command).tip
    assert errors_of(tips[poses.held_out], poses.tip[poses.held_out]).rms < 3e-3


@public("opencr-mujoco", "ftdcr_v4")
def test_a_yielding_backbone_explains_where_ftdcrs_slack_arm_rests() -> None:
    """Slack, the measured arm rests up to 20 mm from where it did before: it depends on which tendon pulled last."""
    design, poses = known.ftdcr_v4(), opencr.read(Path(DATA), "ftdcr_v4", "tendon_pull")
    slack = poses.command.max(axis=1) < -1e-3
    rests = poses.tip[slack]
    assert np.max(np.linalg.norm(rests[:, None] - rests[None], axis=2)) > 0.02
    values = {**defaults(parameters_of(design)), "yielding": 1.0, "yield_curvature": 1.0, "tendon_stiffness": 100.0}
    predicted = predict(build(design, values), poses.command).tip[slack]
    measured, found = (one - one.mean(axis=0) for one in (rests, predicted))
    assert np.sum((measured - found) ** 2) < 0.6 * np.sum(measured**2)  # without memory all rests are one
