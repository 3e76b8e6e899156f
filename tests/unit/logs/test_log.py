"""`tendond log info` and `recover`: contents, health and repair of a log."""

import json
from pathlib import Path

import pytest
from mcap.reader import make_reader

from tendond.offline.logs.info import info
from tendond.offline.logs.log import load as load_log
from tendond.offline.logs.recover import recover
from tests.golden.scripts import CYCLES, FOLDER
from tests.rig.servos import calibration
from tests.unit.logs.commands import damaged, run_command
from tests.unit.logs.logs import rewritten

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


def test_info_tells_what_is_in_a_log_and_that_it_is_whole() -> None:
    found = info(FAULTS)
    assert (found["cycles"], found["first_tick"], found["last_tick"]) == (CYCLES, 0, CYCLES - 1)
    assert (found["complete"], found["damage"], found["missing_ticks"]) == (True, [], 0)
    assert found["duration_s"] == pytest.approx(0.01 * CYCLES)
    assert found["rejected"]["occluded"] == 2
    assert [fault["tick"] for fault in found["faults"]] == [95, 182]
    assert "pose stale" in found["faults"][0]["reason"]
    assert found["snapshots"] == 2
    assert found["metadata"]["rig"] == "paper"


def test_info_is_for_people_or_for_programs() -> None:
    people, programs = run_command("log", "info", str(FAULTS)), run_command("log", "info", str(FAULTS), "--json")
    assert people.returncode == programs.returncode == 0
    assert "complete" in people.stdout
    assert "fault: tendons: servo 2: overload" in people.stdout
    assert json.loads(programs.stdout) == json.loads(json.dumps({**info(FAULTS), "files": [str(FAULTS)]}))


def test_recovering_a_cut_file_keeps_every_whole_chunk_and_names_the_rest(tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(NORMAL.read_bytes()[:150_000])
    found = recover(cut, tmp_path / "new.mcap")
    kept = load_log(cut).records
    assert 0 < found.cycles == len(kept) < CYCLES
    assert [damage.cut for damage in found.damage] == [True]
    new = load_log(tmp_path / "new.mcap")
    assert (new.complete, new.records) == (True, kept)


def test_recovering_a_damaged_file_keeps_what_stands_behind_the_damage_too(tmp_path: Path) -> None:
    whole = load_log(NORMAL).records
    spoiled = damaged(NORMAL, tmp_path / "damaged.mcap")
    found = recover(spoiled, tmp_path / "new.mcap")
    assert found.complete
    assert [damage.what[:13] for damage in found.damage] == ["damaged chunk"]
    ((first, last),) = found.missing
    assert found.last == CYCLES - 1
    kept = load_log(tmp_path / "new.mcap").records
    assert kept == [record for record in whole if not first <= record.tick <= last]


def test_the_command_says_what_was_lost(tmp_path: Path) -> None:
    spoiled = damaged(NORMAL, tmp_path / "damaged.mcap")
    result = run_command("log", "recover", str(spoiled))
    assert result.returncode == 0, result.stderr
    assert "lost: damaged chunk" in result.stdout
    assert "missing: cycles " in result.stdout
    assert (tmp_path / "damaged-recovered.mcap").exists()
    again = run_command("log", "recover", str(spoiled))
    assert again.returncode == 2
    assert "exists already; choose another file" in again.stderr


def test_what_is_whole_is_recovered_without_loss(tmp_path: Path) -> None:
    found = recover(NORMAL, tmp_path / "new.mcap")
    assert (found.damage, found.missing, found.cycles) == ([], [], CYCLES)
    with (tmp_path / "new.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == found.messages == sum(1 for _ in reader.iter_messages())


def test_a_calibration_is_in_the_log_goes_on_to_its_variants_and_is_shown(tmp_path: Path) -> None:
    attached, path = calibration(), NORMAL
    assert load_log(path).calibration == attached
    for arguments in (("--set", "limits.tension_max=40"), ("--closed-loop",)):
        new = tmp_path / f"new{len(arguments)}.mcap"
        assert run_command("log", "what-if", str(path), *arguments, "--out", str(new)).returncode == 0
        assert load_log(new).calibration == attached
    assert (
        "servos   calibrated 2026-01-01T00:00:00+00:00: servo 1 zero 2048"
        in run_command("log", "info", str(path)).stdout
    )
    assert info(path)["calibration"]["tendons"][1]["sign"] == -1


def test_what_stands_beside_the_messages_may_stand_at_the_end(tmp_path: Path) -> None:
    """Other programs that rewrite MCAP files put it there."""
    path = rewritten(NORMAL, tmp_path / "late.mcap", at_end=True)
    assert load_log(path).records == load_log(NORMAL).records
    assert load_log(path).metadata == load_log(NORMAL).metadata
