"""The recorder: what is put is in the file, and nothing that befalls the file reaches the caller."""

import json
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import make_reader
from pydantic import model_serializer

from tendond.daemon.recording import foxglove
from tendond.daemon.recording.batch_queue import WAKE_AT
from tendond.daemon.recording.channels import CHANNELS, CYCLE, LOG
from tendond.daemon.recording.mcap_file import METADATA
from tendond.daemon.recording.recorder import Recorder, RecorderError
from tendond.daemon.recording.run_files import CONFIG
from tendond.offline.logs.container import LogError
from tendond.offline.logs.log import load
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.record import CycleRecord
from tests.unit.offline.records import cycle_record

ROOT = Path(__file__).parents[3]
PATIENCE = 60.0  # [s] for another process on a busy machine


def recorder(path: Path, queue_size: int = 100_000) -> Recorder:
    return Recorder(path, {"revision": "abc"}, {CONFIG: RigConfig().model_dump_json()}, queue_size)


def line(text: str) -> foxglove.Log:
    return foxglove.log_line(0, foxglove.LogLevel.INFO, text)


def test_a_closed_file_holds_every_message_to_the_last_bit(tmp_path: Path) -> None:
    records = [cycle_record(tick, terms=(1 / (tick + 1), -1e-300)) for tick in range(1000)]
    with recorder(tmp_path / "logs" / "run.mcap") as log:
        assert all(log.put(CYCLE, record.tick, record) for record in records)
    assert log.close() == (1000, 1000, 0)
    assert (log.dropped, log.error) == (0, "")
    assert load(log.path).records == records
    assert load(log.path).complete


def test_a_file_names_its_run_and_lists_its_channels(tmp_path: Path) -> None:
    with recorder(tmp_path / "run.mcap") as log:
        log.put(LOG, 5, line("begun"))
    with log.path.open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert {channel.topic for channel in summary.channels.values()} == {channel.topic for channel in CHANNELS}
        assert [(item.name, item.metadata) for item in reader.iter_metadata()] == [
            (METADATA, {"revision": "abc", "part": "0"})
        ]
        assert [RigConfig.model_validate_json(item.data) for item in reader.iter_attachments()] == [RigConfig()]
        ((schema, channel, message),) = reader.iter_messages()
    assert (channel.topic, channel.message_encoding, message.log_time) == ("log", "json", 5)
    assert schema is not None
    assert (schema.name, schema.encoding) == ("foxglove.Log", "jsonschema")
    assert json.loads(message.data)["message"] == "begun"


class Slow(foxglove.Log):
    """Its serialisation waits, as for a disk."""

    @model_serializer
    def _wait(self) -> dict[str, Any]:
        TAKEN.set()
        assert RELEASED.wait(PATIENCE)
        return {"message": self.message}


TAKEN, RELEASED = threading.Event(), threading.Event()


def test_a_full_queue_drops_and_counts_without_waiting(tmp_path: Path) -> None:
    slow = Slow(timestamp=foxglove.timestamp(0), level=foxglove.LogLevel.INFO, message="slow")
    with recorder(tmp_path / "run.mcap", queue_size=10) as log:
        log.put(LOG, 0, slow)
        assert TAKEN.wait(PATIENCE)
        assert [log.put(LOG, 1, line("fits")) for _ in range(10)] == [True] * 10
        assert [log.put(LOG, 1, line("does not")) for _ in range(3)] == [False] * 3
        assert log.dropped == 3
        assert log.close(timeout=0.01) == (14, 0, 14)
        assert "not finished within 0.01 s" in log.error
        RELEASED.set()
        assert log.close(PATIENCE) == (14, 11, 3)


def test_a_message_that_is_no_unicode_costs_only_itself(tmp_path: Path) -> None:
    with recorder(tmp_path / "run.mcap") as log:
        log.put(LOG, 0, line("before"))
        log.put(LOG, 1, line("").model_copy(update={"message": "\ud800"}))
        log.put(LOG, 2, line("after"))
    assert log.close() == (3, 2, 1)
    assert (log.dropped, log.error) == (1, "")


def test_nothing_is_taken_before_opening_or_after_closing(tmp_path: Path) -> None:
    log = recorder(tmp_path / "run.mcap")
    assert not log.put(LOG, 0, line("too early"))
    assert log.close() == (1, 0, 1)
    log.open()
    assert log.put(LOG, 0, line("in time"))
    assert log.close() == log.close() == (2, 1, 1)
    assert not log.put(LOG, 0, line("too late"))
    assert log.dropped == 2


def test_a_file_that_cannot_be_written_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    log = recorder(tmp_path / "file" / "run.mcap")
    with pytest.raises(RecorderError, match=r"run.mcap: no log can be written: .*; choose another file") as caught:
        log.open()
    assert "\n" not in str(caught.value)
    assert log.close() == (0, 0, 0)


def child(path: Path, script: str) -> "subprocess.Popen[str]":
    """A process that runs `script` with an open recorder `log`."""
    start = "import json, random, resource, signal, sys, time\nfrom tests.unit.runtime.test_recorder import *\n"
    return subprocess.Popen(
        [sys.executable, "-c", start + "log = recorder(Path(sys.argv[1]))\nlog.open()\n" + script, str(path)],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )


def records_so_far(path: Path) -> list[CycleRecord]:
    """Records so far of a file that is being written; none while it has no cycle."""
    try:
        return load(path).records
    except LogError:
        return []


def test_what_was_put_reaches_the_disk_though_nothing_follows(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    script = "for tick in range(50): log.put(CYCLE, tick, cycle_record(tick))\nprint(flush=True)\nsys.stdin.read()\n"
    with child(path, script) as process:
        assert process.stdout is not None
        process.stdout.readline()
        deadline = time.monotonic() + PATIENCE
        while len(records_so_far(path)) < 50 and time.monotonic() < deadline:
            time.sleep(0.05)
        process.kill()
    log = load(path)
    assert [record.tick for record in log.records] == list(range(50))
    assert not log.complete


def test_a_killed_process_loses_at_most_a_second(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    # Lines so short that only a flush, never a full chunk, takes them to the disk.
    script = (
        "log.put(CYCLE, 0, cycle_record(0))\n"
        "for tick in range(100_000):\n"
        "    log.put(LOG, tick, line(str(tick)))\n"
        "    print(tick, flush=True)\n"
        "    time.sleep(0.01)\n"
    )
    with child(path, script) as process:
        assert process.stdout is not None
        for _ in range(130):
            process.stdout.readline()
        process.kill()
        rest = process.stdout.read().split()
    last = int(rest[-1]) if rest else 129
    log = load(path)
    found = [int(entry.message) for entry in log.log_lines]
    # Counted in steps of 10 ms, so that a machine that stands still does not matter.
    assert found == list(range(len(found)))
    assert last - found[-1] <= 100
    assert not log.complete


def test_a_full_disk_ends_the_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    script = (
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (400_000, 400_000))\n"
        "size, tick = path.stat().st_size, 0\n"
        "while not log.error:\n"
        "    log.put(CYCLE, tick, cycle_record(tick, terms=[random.random() for _ in range(50)]))\n"
        "    tick += 1\n"
        "    time.sleep(0.3 if path.stat().st_size == size else 0.001)\n"
        "more = [log.put(CYCLE, tick, cycle_record(tick)) for _ in range(10)]\n"
        "print(json.dumps([tick + 10, log.dropped, log.error, more, log.close(), log.close()]))\n"
    )
    with child(path, "path = log.path\n" + script) as process:
        output, _ = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    put, dropped, error, more, counts, again = json.loads(output)
    assert error == f"{path}: the log ended after {put - dropped} messages: File too large"
    assert more == [False] * 10
    assert counts == again == [put, put - dropped, dropped]
    log = load(path)
    read = [record.tick for record in log.records]
    assert read == list(range(len(read)))
    assert 0 < put - dropped <= len(read) < put
    assert not log.complete


def test_it_rests_while_its_caller_works_and_a_caller_that_hangs_does_not_end_the_log(tmp_path: Path) -> None:
    with recorder(tmp_path / "run.mcap") as log:
        for cycle in range(3):
            log.rest_from = time.monotonic()  # the caller works from now on, and hangs in the last cycle
            for number in range(WAKE_AT):
                log.put(LOG, 10 * cycle + number, line("waits"))
        deadline = time.monotonic() + PATIENCE
        while log.waiting:
            assert time.monotonic() < deadline
            time.sleep(0.001)
    assert log.close() == (3 * WAKE_AT, 3 * WAKE_AT, 0)


def test_an_entry_that_wakes_nobody_is_written_all_the_same(tmp_path: Path) -> None:
    with recorder(tmp_path / "run.mcap") as log:
        log.put(LOG, 0, line("alone"))
        deadline = time.monotonic() + PATIENCE
        while log.waiting:
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert log.close() == (1, 1, 0)
