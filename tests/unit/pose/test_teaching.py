"""Paths that somebody has shown: smoothed, without stillness, in a file that a reference reads."""

from pathlib import Path

import numpy as np
import pytest

from tendond.cli.common import read_rows
from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.teaching.path import Columns, Shown, shown, smoothed, write_path
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.messages import TipPose


def hand(noise: float = 2e-4, seconds: float = 6.0) -> list[tuple[float, TipPose]]:
    """Return poses at 100 Hz: a second of rest, a quarter of a circle, and rest again."""
    rng = np.random.default_rng(4)
    poses = []
    for k in range(int(seconds * 100)):
        phase = 0.5 * np.pi * np.clip((0.01 * k - 1.0) / 3.0, 0.0, 1.0)
        place = np.array([0.1 * np.sin(phase), 0.1 * (1.0 - np.cos(phase)), 0.3]) + noise * rng.normal(size=3)
        turn = (float(np.cos(0.5 * phase)), 0.0, float(np.sin(0.5 * phase)), 0.0)
        pose = TipPose(seq=k, stamp_ns=k * 10_000_000, position=tuple(place.tolist()), orientation=turn)
        poses.append((0.01 * k, pose))
    return poses


def test_the_path_begins_and_ends_with_the_motion_and_is_smoother_than_the_camera() -> None:
    rows = smoothed(shown(hand()), 0.1)
    assert 2.5 < rows[-1, 0] < 3.3
    assert rows[0, 0] == 0.0
    phase = np.arctan2(rows[:, 1], 0.1 - rows[:, 2])
    circle = np.column_stack((0.1 * np.sin(phase), 0.1 * (1.0 - np.cos(phase)), np.full(len(rows), 0.3)))
    assert np.sqrt(np.mean((rows[:, 1:4] - circle) ** 2)) < 2e-4
    assert np.allclose(np.linalg.norm(rows[:, 4:], axis=1), 1.0)
    assert np.allclose(rows[:, 4], np.sin(phase), atol=0.03)


def test_a_gap_in_the_poses_and_a_still_arm_are_named() -> None:
    poses = hand()
    with pytest.raises(UsageError, match=r"no valid pose for 1\.0"):
        smoothed(shown(poses[:150] + poses[250:]), 0.1)
    with pytest.raises(UsageError, match="has not moved"):
        smoothed(shown(poses[:90]), 0.1)
    with pytest.raises(UsageError, match="only 1 valid poses"):
        shown([poses[0]] * 20)


@pytest.mark.parametrize(("columns", "width"), [("direction", 7), ("position", 4), ("xz", 3), ("yz", 3)])
def test_the_file_has_a_heading_with_units_and_is_read_as_samples(tmp_path: Path, columns: Columns, width: int) -> None:
    file = tmp_path / "path.csv"
    count = write_path(smoothed(shown(hand()), 0.1), columns, file)
    assert file.read_text().splitlines()[0].startswith("time [s],")
    section = ReferenceSection.model_validate({"kind": "samples", **read_rows(file, "samples")})
    assert len(section.samples) == count
    assert {len(row) for row in section.samples} == {width}
    assert section.has_poses == (columns == "direction")


def test_a_folder_that_does_not_exist_is_named(tmp_path: Path) -> None:
    with pytest.raises(DaemonError, match="choose another file with --out"):
        write_path(np.zeros((3, 7)), "xz", tmp_path / "none" / "path.csv")


def test_without_smoothing_the_poses_are_kept() -> None:
    time = np.linspace(0.0, 2.0, 201)
    place = np.column_stack((0.05 * np.sin(np.pi * time / 4.0), 0.0 * time, 0.3 + 0.0 * time))
    rows = smoothed(Shown(time, place, np.tile([0.0, 0.0, 1.0], (201, 1))), 0.0, trim=False)
    assert np.allclose(rows[:, 1], 0.05 * np.sin(np.pi * rows[:, 0] / 4.0), atol=3e-4)
