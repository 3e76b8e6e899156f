"""Adapters of measured poses, on small files of the same format, and the split by blocks of the sequence."""

from pathlib import Path

import numpy as np
import pytest

from tendond.offline.validation.datasets import armlab, opencr, table
from tendond.offline.validation.datasets.catalogue import load
from tendond.offline.validation.datasets.poses import DatasetError, Poses, split_evenly, thinned, turning_points
from tests.unit.validation.robots import simulated

HEADING = (
    "timestamp,pattern_label," + ",".join(f"servo_{i}_mm" for i in (4, 3, 9, 5, 2, 8, 6, 1, 7)) + ",tip_x,tip_y,tip_z"
)


def test_armlabs_units_are_tenths_of_a_millimetre_and_millimetres(tmp_path: Path) -> None:
    file = tmp_path / armlab.FILE
    file.parent.mkdir()
    file.write_text("".join(f"0,{i},25,-43.5,{i},276.5\n" for i in range(100)))
    poses = armlab.read(tmp_path)
    np.testing.assert_allclose(poses.command[3], (0.0, 3e-4, 25e-4))
    np.testing.assert_allclose(poses.tip[3], (-0.0435, 0.003, 0.2765))
    assert len(poses) == 100
    assert 0.1 < poses.held_out.mean() < 0.3


def write_opencr(folder: Path, kind: str, rows: list[tuple[str, float]]) -> None:
    """Write rows of (label, time); servo i is at -time + i, the tip at 10, 20, 30 mm."""
    folder.mkdir(parents=True, exist_ok=True)
    lines = [
        f"{time},{label}," + ",".join(f"{-time + i}" for i in range(9)) + ",10.0,20.0,30.0" for label, time in rows
    ]
    (folder / f"tdcr_sysid_1_{kind}.csv").write_text("\n".join([HEADING, *lines]) + "\n")


def test_the_authors_validation_file_is_what_is_held_out(tmp_path: Path) -> None:
    folder = tmp_path / "opencr-mujoco" / "ftdcr_v4"
    rows = [("a", 1.0), ("a_hold", 2.0), ("b", 3.0), ("c", 4.0)]
    write_opencr(folder, "keypoints", rows)
    write_opencr(folder, "val", rows[3:])
    poses = opencr.read(tmp_path, "ftdcr_v4", "val")
    assert poses.held_out.tolist() == [False, False, False, True]
    assert poses.label == ("a", "b", "c")  # a pattern and its hold are one block
    np.testing.assert_allclose(poses.command[2], (np.arange(9) - 3.0) * 1e-3)
    np.testing.assert_allclose(poses.tip[0], (0.01, 0.02, 0.03))


def test_single_pulls_are_held_out_by_runs_within_a_pull(tmp_path: Path) -> None:
    folder = tmp_path / "opencr-mujoco" / "ftdcr_v4"
    write_opencr(
        folder, "tendon_pull", [(label, 20.0 * turn + i) for turn, label in enumerate("ab") for i in range(10)]
    )
    poses = opencr.read(tmp_path, "ftdcr_v4", "tendon_pull")
    assert poses.block.tolist() == [0] * 4 + [1] * 4 + [2] * 2 + [3] * 4 + [4] * 4 + [5] * 2
    assert np.unique(poses.block[poses.held_out]).tolist() == [1, 4]


def test_a_labs_own_file_may_name_its_blocks(tmp_path: Path) -> None:
    file = tmp_path / "mine.csv"
    rows = [f"{i // 4 + 10},0.001,{i * 1e-4:.4f},0.1,0.2,{i / 100}" for i in range(40)]
    file.write_text("\n".join(["block,displacement_0,displacement_1,x,y,z", *rows]))
    poses, entry = load(str(file))
    assert entry is None
    assert poses.tendons == 2
    assert poses.block.tolist() == [i // 4 for i in range(40)]
    np.testing.assert_allclose(poses.tip[-1], (0.1, 0.2, 0.39))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x,y,z\n1,2,3\n", "a column is missing"),
        ("displacement_0,x,y,z\n0,1,2,3\n0,1,far,3\n", ":3: y = 'far' is not a number"),
        ("displacement_0,x,y,z\n0,1,2,3\n0,1,nan,3\n", ":3: y = 'nan' is not finite: leave out that pose"),
        ("displacement_0,x,y,z\n0,1,2,nan\n0,1,2,3\n", "not finite"),
        ("displacement_0,x,y,z\n0,1,2,3\n", "too few to hold a part out"),
        ("block,displacement_0,x,y,z\n2,0,1,2,3\n1,0,1,2,3\n", "in the order of the sequence"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "mine.csv"
    file.write_text(text)
    with pytest.raises(DatasetError, match=said):
        table.read(file)


@pytest.mark.parametrize("dataset", ["armlab", "ftdcr_v4-val", "ftdcr_v6-val"])
def test_missing_data_are_refused_with_where_to_get_them(
    dataset: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("TENDOND_REFERENCE_DATA", raising=False)
    for folder in ("", str(tmp_path)):
        with pytest.raises(DatasetError, match=r"get it from github\.com/"):
            load(dataset, folder)


def test_another_split_holds_out_every_so_many_th_block_under_a_name_of_its_own() -> None:
    poses = simulated()
    split = split_evenly(poses, 3)
    assert split.name == f"{poses.name}-every3"
    assert np.unique(split.block[split.held_out] % 3).tolist() == [1]
    assert split.held_out.sum() == (poses.block % 3 == 1).sum()


def test_a_block_is_held_out_whole_or_not_at_all() -> None:
    poses = simulated()
    torn = poses.held_out.copy()
    torn[np.flatnonzero(torn)[0]] = False
    with pytest.raises(DatasetError, match="in part only"):
        Poses(poses.name, poses.source, poses.command, poses.tip, poses.block, poses.label, torn)


def test_thinning_keeps_the_order_and_where_commands_turn_round() -> None:
    poses = simulated()
    few = thinned(poses, 20)
    assert len(few) < len(poses)
    turns = poses.command[turning_points(poses.command)]
    assert all(any(np.array_equal(one, other) for other in few.command) for one in turns)
    assert np.all(np.diff(few.block) >= 0)
