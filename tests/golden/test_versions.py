"""Logs of every format are read as they are, without a migration; one of a later format is refused in a line."""

import json
from pathlib import Path

import pytest

from tendond.daemon.recording.mcap_file import McapFile
from tendond.daemon.recording.run_files import CONFIG, FORMAT, LOG_FORMAT
from tendond.daemon.recording.run_metadata import run_metadata
from tendond.offline.logs import load
from tendond.schemas.config.rig import RigConfig
from tests.golden.scripts import CYCLES, FOLDER, RUNS
from tests.unit.cli.commands import tendond

LOGS = [folder / f"{name}.mcap" for folder in (FOLDER, FOLDER / "v1") for name in RUNS]


@pytest.mark.parametrize("path", LOGS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_log_of_any_version_is_loaded_described_and_exported(
    path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = load(path)
    assert len(run) == CYCLES
    assert run["tension_estimate"].shape == run["command.tension"].shape
    info = json.loads(tendond(capsys, "log", "info", str(path), "--json").out)
    assert (info["cycles"], info["damage"]) == (CYCLES, [])
    table = tmp_path / "run.csv"
    assert tendond(capsys, "log", "export", str(path), "--out", str(table)).status == 0
    assert len(table.read_text().splitlines()) == CYCLES + 1


def test_a_log_says_its_format() -> None:
    assert run_metadata(RigConfig())[FORMAT] == str(LOG_FORMAT)


def test_a_log_of_a_later_format_is_refused_in_a_line_that_says_what_reads_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.mcap"
    metadata = {FORMAT: str(LOG_FORMAT + 1), "tendond": "9.1.0"}
    McapFile(path, metadata, {CONFIG: '{"section": "of the future"}'}).finish()
    ended = tendond(capsys, "log", "info", str(path))
    assert (ended.status, ended.said.count("\n")) == (2, 1)
    assert f"is a log of format {LOG_FORMAT + 1}" in ended.said
    assert "read it with tendond 9.1.0 or later" in ended.said
