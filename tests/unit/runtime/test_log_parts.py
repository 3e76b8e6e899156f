"""A long run's files: each stands alone, none is missing, and one that cannot be begun ends the log."""

import random
import time
from pathlib import Path

from tendond.daemon.control.snapshot import StateSnapshot
from tendond.daemon.recording.channels import CYCLE, LOG, STATE
from tendond.daemon.recording.recorder import Recorder
from tendond.daemon.recording.run_files import CONFIG
from tendond.offline.logs.log import load
from tendond.schemas.config.rig import RigConfig
from tests.unit.offline.records import cycle_record
from tests.unit.runtime.test_recorder import line


def state(tick: int) -> StateSnapshot:
    """First message of each file of a split run."""
    return StateSnapshot(tick=tick, state="{}")


def test_a_long_run_is_split_into_files_that_stand_alone_and_miss_nothing(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    log = Recorder(path, {"revision": "abc"}, {CONFIG: RigConfig().model_dump_json()}, 100_000, split_bytes=100_000)
    with log:
        for tick in range(2000):
            if tick % 20 == 0:
                log.put(STATE, tick, state(tick))
            log.put(CYCLE, tick, cycle_record(tick, terms=[random.random() for _ in range(50)]))
            log.put(LOG, tick, line(str(tick)))
    assert log.close() == (4100, 4100, 0)
    assert [record.tick for record in load(path).records] == list(range(2000))
    parts = []
    for number, file in enumerate(sorted(tmp_path.glob("*.mcap"), key=lambda file: (len(file.name), file.name))):
        alone = tmp_path / str(number) / file.name
        alone.parent.mkdir()
        parts.append(load(file.rename(alone)))
    assert len(parts) > 3
    assert [part.path.name for part in parts[:3]] == ["run.mcap", "run-001.mcap", "run-002.mcap"]
    assert all(part.complete and part.config == RigConfig() for part in parts)
    assert [part.metadata["part"] for part in parts] == [str(k) for k in range(len(parts))]
    assert [record.tick for part in parts for record in part.records] == list(range(2000))
    for part in parts:  # a cycle is never torn apart
        assert [record.tick for record in part.records] == [int(entry.message) for entry in part.log_lines]


def test_a_run_is_split_by_time_as_well(tmp_path: Path) -> None:
    log = Recorder(tmp_path / "run.mcap", {}, {CONFIG: RigConfig().model_dump_json()}, 1000, split_seconds=0.05)
    with log:
        for tick in range(20):
            log.put(STATE, tick, state(tick))
            log.put(CYCLE, tick, cycle_record(tick))
            time.sleep(0.01)
    assert len(list(tmp_path.iterdir())) > 1


def test_a_next_file_that_cannot_be_opened_ends_the_log_and_says_so(tmp_path: Path) -> None:
    (tmp_path / "run-001.mcap").write_text("precious")
    log = Recorder(tmp_path / "run.mcap", {}, {CONFIG: RigConfig().model_dump_json()}, 100_000, split_bytes=10_000)
    with log:
        for tick in range(500):
            log.put(STATE, tick, state(tick))
            log.put(CYCLE, tick, cycle_record(tick, terms=[random.random() for _ in range(50)]))
    put, written, dropped = log.close()
    assert (put, written + dropped) == (1000, 1000)
    assert "File exists" in log.error
    assert [record.tick for record in load(log.path).records] == list(range(written // 2))  # a state to each cycle
    assert (tmp_path / "run-001.mcap").read_text() == "precious"
