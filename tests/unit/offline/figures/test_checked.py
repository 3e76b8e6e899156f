"""Pictures get into the documents only from runs in which no pose was lost and the tip settled."""

from pathlib import Path

import pytest

from tendond.cli.manual.checked import faults_of, main
from tendond.offline.logs.log import load
from tendond.schemas.record import CycleRecord
from tests.unit.offline.figures.logs import approach, idle
from tests.unit.offline.figures.logs import write_simulated as write


def copied(folder: Path, records: list[CycleRecord]) -> tuple[int, bool]:
    """Exit status, and whether the picture was copied."""
    log = write(folder / "run.mcap", records)
    (folder / "shapes.png").write_bytes(b"picture")
    target = folder / "docs" / "shapes.png"
    return main([str(log), "--", str(folder / "shapes.png"), str(target)]), target.exists()


def test_a_good_run_gets_its_pictures_into_the_documents(tmp_path: Path) -> None:
    assert copied(tmp_path, idle(0, 5) + approach(5, 60)) == (0, True)


def test_a_run_that_did_not_settle_or_lost_a_pose_gets_none(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert copied(tmp_path, approach(0, 5)) == (1, False)
    assert "not a run to show: run.mcap: run 1 did not settle" in capsys.readouterr().err
    records = approach(0, 60)
    records[30] = records[30].model_copy(update={"inputs": records[30].inputs.model_copy(update={"pose": None})})
    log = load(write(tmp_path / "lost.mcap", records))
    assert faults_of(log) == ["lost.mcap: 1 of 60 cycles of tracking have no pose"]
    assert faults_of(load(write(tmp_path / "idle.mcap", idle(0, 5)))) == ["idle.mcap: nothing tracks"]
