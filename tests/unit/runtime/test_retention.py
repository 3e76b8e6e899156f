"""Logs are kept within a size and an age, the oldest are removed first, and what is not ours is never touched."""

import os
import shutil
import time
from pathlib import Path

import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.recording import run_log as run_log_module
from tendond.daemon.recording.cycle_entries import Cycle
from tendond.daemon.recording.run_log import RunLog
from tendond.daemon.recording.storage.retention import DAY, Retention, retention
from tendond.offline.logs.log import load
from tendond.schemas.config.machine import LogSection
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs

MB = 1_000_000


def log(folder: Path, name: str, size: int, days_old: float) -> Path:
    path = folder / name
    path.write_bytes(bytes(size))
    changed = time.time() - days_old * DAY
    os.utime(path, (changed, changed))
    return path


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def test_the_oldest_go_first_until_a_new_file_fits(tmp_path: Path) -> None:
    for day in range(6):
        log(tmp_path, f"arm-2026010{6 - day}T000000Z.mcap", MB, day)
    removed = Retention(tmp_path, "arm", 4.5 * MB, None).prune(MB)
    assert [path.name[4:12] for path in removed] == ["20260101", "20260102", "20260103"]
    assert len(names(tmp_path)) == 3


def test_what_is_too_old_goes_whatever_its_size(tmp_path: Path) -> None:
    log(tmp_path, "arm-20260101T000000Z.mcap", 10, 91.0)
    log(tmp_path, "arm-20260101T000000Z-001.mcap", 10, 89.0)
    Retention(tmp_path, "arm", None, 90 * DAY).prune(MB)
    assert names(tmp_path) == {"arm-20260101T000000Z-001.mcap"}


def test_other_files_other_rigs_and_named_logs_are_never_removed(tmp_path: Path) -> None:
    kept = ["arm2-20260101T000000Z.mcap", "arm-experiment-7.mcap", "notes.txt", "arm-20260101T000000Z.csv"]
    for name in kept:
        log(tmp_path, name, MB, 1000.0)
    log(tmp_path, "arm-20260101T000000Z.mcap", MB, 1000.0)
    Retention(tmp_path, "arm", 1.0, DAY).prune(MB)
    assert names(tmp_path) == set(kept)


def test_by_hand_nothing_is_removed_unless_asked_for_and_a_service_has_bounds(tmp_path: Path) -> None:
    assert not retention(LogSection(), tmp_path, "arm", service=False).is_bounded
    found = retention(LogSection(), tmp_path, "arm", service=True)
    assert found.size == min(20e9, 0.1 * shutil.disk_usage(tmp_path).total)
    assert found.age == 90 * DAY
    unbounded = retention(LogSection(keep_size=0.0, keep_days=0.0), tmp_path, "arm", service=True)
    assert not unbounded.is_bounded
    assert retention(LogSection(keep_size=3.0), tmp_path, "arm", service=False).size == 3e9


def test_the_days_left_are_those_at_the_growth_of_the_last_days(tmp_path: Path) -> None:
    begun = time.strftime("%Y%m%dT%H%M%SZ", time.gmtime(time.time() - 2 * DAY))
    log(tmp_path, f"arm-{begun}.mcap", 2 * MB, 1.0)
    log(tmp_path, f"arm-{begun}-001.mcap", 2 * MB, 0.0)
    space = Retention(tmp_path, "arm", 10 * MB, None).disk_space()
    assert space.rate == pytest.approx(2 * MB, rel=0.01)
    assert space.days == pytest.approx(3.0, rel=0.01)
    assert Retention(tmp_path / "..", "nobody", None, None).disk_space().days is None


def test_a_run_that_goes_on_and_on_stays_within_its_bound_and_never_removes_the_file_that_it_writes(
    tmp_path: Path,
) -> None:
    config = parse_config("[rod]\nnodes = 6\n[log]\nidle_period = 0.0\nsplit_size = 0.1\nqueue = 100000", "test")
    setup = CycleSetup.from_config(config)
    bound = 600_000.0
    old = log(tmp_path, "paper-20250101T000000Z.mcap", 300_000, 30.0)
    path = tmp_path / "paper-20260101T000000Z.mcap"
    kept = Retention(tmp_path, "paper", bound, None)

    def used() -> float:
        return sum(size for _, size, _ in kept.files())

    with RunLog(path, config, setup.rod, retention=kept) as run_log:
        state = initial_state(setup)
        run_log.state(state)
        for _ in range(6000):
            state, _, record = step(setup, state, CycleInputs())
            run_log.cycle(record, None, state.rod, None)
            run_log.state(state)
            if record.tick % 100 == 0:
                while run_log.waiting > 1000:
                    time.sleep(0.01)
                assert used() < bound + 200_000
        assert run_log.days_left is None or run_log.days_left >= 0.0
    assert (run_log.error, run_log.dropped) == ("", 0)
    newest = max(tmp_path.glob("*.mcap"), key=lambda one: one.stat().st_mtime)
    assert any("removed 1 old logs, paper-20260101T" in line.message for line in load(newest).log_lines)
    parts = sorted(path.name for path in tmp_path.glob("*.mcap"))
    assert old.name not in parts
    assert path.name not in parts  # the first part of this run has gone as well
    assert len(parts) >= 3
    assert used() < bound + 200_000


def test_while_the_arm_is_held_old_logs_stay_until_it_is_not_unless_the_disk_has_no_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = parse_config("[rod]\nnodes = 6\n[log]\nidle_period = 0.0\n", "test")
    setup = CycleSetup.from_config(config)
    old = log(tmp_path, "paper-20250101T000000Z.mcap", 1000, 100.0)
    kept = Retention(tmp_path, "paper", None, 90 * DAY)
    monkeypatch.setattr(run_log_module, "LOOK_SECONDS", 0.0)
    state = initial_state(setup)
    _, _, record = step(setup, state, CycleInputs())
    held = record.model_copy(update={"mode": Mode.TRACKING})
    run_log = RunLog(tmp_path / "paper-20260101T000000Z.mcap", config, setup.rod, retention=kept)
    run_log._cycle_entries(Cycle(0, held, None, None, state.rod, None))
    run_log._make_room(tmp_path / "paper-20260101T000000Z-001.mcap")
    run_log._cycle_entries(Cycle(0, held, None, None, state.rod, None))
    assert old.exists()
    run_log._cycle_entries(Cycle(0, record, None, None, state.rod, None))
    assert not old.exists()
    full = log(tmp_path, "paper-20250102T000000Z.mcap", 1000, 100.0)
    run_log._cycle_entries(Cycle(0, held, None, None, state.rod, None))
    monkeypatch.setattr(run_log_module, "FILES_IN_RESERVE", 1e9)
    run_log._make_room(tmp_path / "paper-20260101T000000Z-002.mcap")
    assert not full.exists()
