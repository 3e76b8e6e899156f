"""`tendond log list, tag, note, prune, verify`: the runs of a folder, without changing a log."""

import hashlib
import json
import os
import shutil
import time
from pathlib import Path

import pytest

from tendond.daemon.recording.mcap_file import McapFile
from tendond.daemon.recording.run_files import CONFIG, part_path
from tendond.daemon.recording.storage.retention import DAY
from tendond.offline.log_index.index import INDEX, list_runs
from tendond.offline.log_index.scan import ScannedFile, scan
from tendond.schemas.config.rig import RigConfig
from tests.golden.scripts import FOLDER
from tests.unit.cli.commands import tendond

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with golden logs of this version and of version 1, one that is cut off, and a file that is no log."""
    shutil.copy(FOLDER / "normal.mcap", tmp_path / "normal.mcap")
    shutil.copy(FOLDER / "faults.mcap", tmp_path / "faults.mcap")
    shutil.copy(FOLDER / "v1" / "faults.mcap", tmp_path / "first.mcap")
    (tmp_path / "cut.mcap").write_bytes((FOLDER / "normal.mcap").read_bytes()[:50_000])
    (tmp_path / "text.mcap").write_text("no log")
    (tmp_path / "notes.txt").write_text("of something else")
    return tmp_path


def listed(capsys: Capture, *arguments: str) -> dict[str, dict[str, object]]:
    ended = tendond(capsys, "log", "list", *arguments, "--json")
    assert ended.status == 0, ended.said
    return {run["run"]: run for run in json.loads(ended.out)}


def hashes(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in folder.glob("*.mcap")}


def test_every_log_is_listed_with_what_it_was_damaged_and_old_ones_as_well(folder: Path, capsys: Capture) -> None:
    runs = listed(capsys, str(folder))
    assert set(runs) == {"normal", "faults", "first", "cut", "text"}
    assert runs["normal"]["law"] == "backstepping"
    assert (runs["normal"]["faults"], runs["normal"]["complete"]) == ([], True)
    info = json.loads(tendond(capsys, "log", "info", str(folder / "faults.mcap"), "--json").out)
    for name in ("faults", "first"):
        assert runs[name]["faults"] == [change["reason"] for change in info["faults"]] != []
        assert runs[name]["cycles"] == info["cycles"]
    assert (runs["cut"]["complete"], runs["cut"]["problem"]) == (False, "")
    assert "is not an MCAP file" in str(runs["text"]["problem"])
    table = tendond(capsys, "log", "list", str(folder))
    assert table.said.startswith("tendond: text.mcap: is not an MCAP file")
    for name in runs:
        assert f"\n{name} " in table.out


def test_the_index_spares_reading_a_log_again_and_is_made_anew_where_it_is_gone_or_wrong(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = list_runs(folder)
    read: list[Path] = []

    def counted(path: Path) -> ScannedFile:
        read.append(path)
        return scan(path)

    monkeypatch.setattr("tendond.offline.log_index.index.scan", counted)
    assert list_runs(folder) == first
    assert read == []
    os.utime(folder / "normal.mcap")
    assert list_runs(folder) == first
    assert [path.name for path in read] == ["normal.mcap"]
    for wrong in ("{", "[]", '{"version": 99, "files": {}}', '{"version": 1, "files": {"normal.mcap": {"stamp": 1}}}'):
        (folder / INDEX).write_text(wrong)
        assert list_runs(folder) == first
    (folder / INDEX).unlink()
    assert list_runs(folder) == first


def test_tags_and_notes_stand_beside_the_log_which_stays_as_it_is(folder: Path, capsys: Capture) -> None:
    before = hashes(folder)
    log = str(folder / "normal.mcap")
    assert tendond(capsys, "log", "tag", log, "demo", "figure-3").out == "normal: demo figure-3\n"
    assert tendond(capsys, "log", "tag", log, "demo", "--remove").out == "normal: figure-3\n"
    ended = tendond(capsys, "log", "note", log, "tendon 2 was [slack]")
    assert ended.out.endswith("  tendon 2 was [slack]\n")
    assert hashes(folder) == before
    run = listed(capsys, str(folder))["normal"]
    assert run["tags"] == ["figure-3"]
    assert "tendon 2 was [slack]" in str(run["notes"])
    assert set(listed(capsys, str(folder), "--tag", "figure-3")) == {"normal"}
    assert set(listed(capsys, str(folder), "--search", "SLACK")) == {"normal"}
    assert set(listed(capsys, str(folder), "--search", "overload")) == {"faults", "first"}
    assert listed(capsys, str(folder), "--tag", "figure-3", "--tag", "demo") == {}
    assert tendond(capsys, "log", "tag", log, "figure-3", "--remove").out == "normal: no tags\n"
    assert tendond(capsys, "log", "tag", log).out == "normal: no tags\n"


@pytest.mark.parametrize("tag", ["Demo", "a b", "", "-x" * 20])
def test_a_tag_that_is_none_is_refused_in_a_line(folder: Path, capsys: Capture, tag: str) -> None:
    ended = tendond(capsys, "log", "tag", str(folder / "normal.mcap"), "--", tag)
    assert (ended.status, ended.said.count("\n")) == (2, 1)
    assert "is no tag: use" in ended.said
    assert not list(folder.glob("*.notes.json"))


def test_damaged_notes_are_named_and_never_overwritten(folder: Path, capsys: Capture) -> None:
    notes = folder / "normal.notes.json"
    notes.write_text('{"version": 2}')
    ended = tendond(capsys, "log", "tag", str(folder / "normal.mcap"), "demo")
    assert (ended.status, ended.said.count("\n")) == (2, 1)
    assert "normal.notes.json: version: " in ended.said
    assert notes.read_text() == '{"version": 2}'
    assert "normal.notes.json" in str(listed(capsys, str(folder))["normal"]["problem"])


def a_log(path: Path, days: float = 0.0, part: int = 0) -> Path:
    """A finished log without cycles, of some days ago."""
    metadata = {"rig": "arm", "part": str(part)}
    McapFile(path, metadata, {CONFIG: RigConfig().model_dump_json()}).finish()
    changed = time.time() - days * DAY
    os.utime(path, (changed, changed))
    return path


def test_a_checksum_is_made_while_a_log_is_written_and_finds_a_change(tmp_path: Path, capsys: Capture) -> None:
    log = a_log(tmp_path / "run.mcap")
    assert (tmp_path / "run.mcap.sha256").read_text() == f"{hashes(tmp_path)['run.mcap']}  run.mcap\n"
    ended = tendond(capsys, "log", "verify", str(tmp_path))
    assert (ended.status, ended.out) == (0, f"{log}: intact\n")
    data = bytearray(log.read_bytes())
    data[len(data) // 2] ^= 1
    log.write_bytes(data)
    ended = tendond(capsys, "log", "verify", str(log))
    assert ended.status == 1
    assert f"{log}: changed" in ended.out
    (tmp_path / "run.mcap.sha256").write_text("nonsense")
    assert tendond(capsys, "log", "verify", str(log)).status == 1


def test_a_log_without_a_checksum_is_named_and_gets_one_on_request(folder: Path, capsys: Capture) -> None:
    log = folder / "first.mcap"
    ended = tendond(capsys, "log", "verify", str(log))
    assert (ended.status, "no checksum" in ended.out) == (0, True)
    assert "recorded" in tendond(capsys, "log", "verify", str(log), "--record").out
    assert "intact" in tendond(capsys, "log", "verify", str(log)).out
    ended = tendond(capsys, "log", "verify", str(folder / "nowhere.mcap"))
    assert (ended.status, ended.said.count("\n")) == (2, 1)


def test_prune_says_what_and_why_and_removes_on_request_only(tmp_path: Path, capsys: Capture) -> None:
    old = a_log(tmp_path / "arm-20260101T000000Z.mcap", 40.0)
    new = a_log(tmp_path / "arm-20260201T000000Z.mcap", 1.0)
    config = tmp_path / "rig.toml"
    config.write_text('[rig]\nname = "arm"\n[log]\nkeep_days = 30\n')
    command = ("log", "prune", str(tmp_path), "-c", str(config))
    ended = tendond(capsys, *command)
    assert ended.status == 0
    assert ended.out.startswith(f"{old.name}  ")
    assert "older than 30 days" in ended.out
    assert "not removed; add --yes" in ended.said
    assert old.exists()
    (row,) = json.loads(tendond(capsys, *command, "--json").out)
    assert (row["path"], row["reason"], row["removed"]) == (str(old), "age", False)
    assert "removed 1 files of 1" in tendond(capsys, *command, "--yes").out
    assert not old.exists()
    assert not Path(f"{old}.sha256").exists()
    assert new.exists()
    assert "no log of rig 'arm'" in tendond(capsys, *command).out
    assert "beyond 1e-06 GB" in tendond(capsys, *command, "--keep-size", "1e-6", "--keep-days", "0").out
    assert tendond(capsys, "log", "prune", str(tmp_path)).status == 2


def test_tagged_logs_and_one_that_is_being_written_are_never_removed(tmp_path: Path, capsys: Capture) -> None:
    first = a_log(tmp_path / "arm-20260101T000000Z.mcap", 40.0)
    parts = [a_log(part_path(first, number), 40.0, number) for number in (1, 2)]
    assert tendond(capsys, "log", "tag", str(parts[1]), "demo").out == "arm-20260101T000000Z: demo\n"
    path = tmp_path / "arm-20260102T000000Z.mcap"
    running = McapFile(path, {}, {})
    changed = time.time() - 40.0 * DAY
    os.utime(path, (changed, changed))
    damaged = a_log(tmp_path / "arm-20260103T000000Z.mcap", 40.0)
    (tmp_path / "arm-20260103T000000Z.notes.json").write_text("{")
    config = tmp_path / "rig.toml"
    config.write_text('[rig]\nname = "arm"\n[log]\nkeep_days = 30\nkeep_size = 1e-6\n')
    command = ("log", "prune", str(tmp_path), "-c", str(config), "--yes")
    assert "no log of rig 'arm'" in tendond(capsys, *command).out
    running.abandon()
    tendond(capsys, "log", "tag", str(first), "demo", "--remove")
    assert "removed 4 files of 4" in tendond(capsys, *command).out
    assert damaged.exists()
    assert [one.name for one in tmp_path.glob("*.mcap")] == [damaged.name]


def test_a_folder_that_is_none_is_named(tmp_path: Path, capsys: Capture) -> None:
    for command in ("list", "prune"):
        ended = tendond(capsys, "log", command, str(tmp_path / "none"))
        assert (ended.status, ended.said.count("\n")) == (2, 1)
        assert "none: " in ended.said
    assert "no logs" in tendond(capsys, "log", "list", str(tmp_path)).said
