"""Replay: a log computes again to the same bytes, or says where it does not."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import StateSnapshot, decode_state, encode_state
from tendond.daemon.control.state import CycleState, initial_state
from tendond.daemon.recording.channels import CYCLE, STATE
from tendond.model.rod.state import RodState
from tendond.offline.bench.replay import bench_replay
from tendond.offline.logs import load
from tendond.offline.logs.container import LogError
from tendond.offline.logs.container import records as mcap_records
from tendond.offline.logs.run import open_run
from tendond.offline.replay.changes import parameter_changes, version_changes
from tendond.offline.replay.difference import Field, compare
from tendond.offline.replay.rerun import inputs_of, rerun
from tendond.schemas.config.rig import parse_config
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.golden.scripts import CONFIG, CYCLES, FOLDER
from tests.unit.logs.commands import run_command
from tests.unit.logs.logs import Change, rewritten, write_parts

NORMAL = FOLDER / "normal.mcap"


def test_a_state_comes_back_from_its_text_to_the_last_bit_and_goes_on_alike() -> None:
    setup = CycleSetup.from_config(parse_config(CONFIG, "test"))
    state = initial_state(setup)
    for tick in range(30):
        state, _, _ = step(setup, state, CycleInputs(request=ControlAction.ARM if tick == 3 else None))
    again = decode_state(CycleState, encode_state(state), setup)
    assert encode_state(again) == encode_state(state)
    assert isinstance(again.rod, RodState)
    assert isinstance(state.rod, RodState)
    np.testing.assert_array_equal(again.rod.levels, state.rod.levels)
    assert again.rod.levels.flags.writeable
    after, other = (step(setup, one, CycleInputs())[2].model_dump_json() for one in (state, again))
    assert after == other


def test_a_state_of_another_version_is_named() -> None:
    setup = CycleSetup.from_config(parse_config(CONFIG, "test"))
    data = json.loads(encode_state(initial_state(setup)))
    for other in ({**data, "of_another": 1}, {name: value for name, value in data.items() if name != "mode_since"}):
        with pytest.raises(ValueError, match=r"is no CycleState of this version .*CycleState: (of_another|mode_since)"):
            decode_state(CycleState, json.dumps(other), setup)


def test_a_state_written_before_a_field_was_added_has_its_default() -> None:
    setup = CycleSetup.from_config(parse_config(CONFIG, "test"))
    state = initial_state(setup)
    data = json.loads(encode_state(state))
    del data["jump_watch"]["rested"]
    assert encode_state(decode_state(CycleState, json.dumps(data), setup)) == encode_state(state)


def test_a_log_replays_to_the_same_bytes_in_one_process_or_several(recorded: Path) -> None:
    outcome = rerun(recorded, jobs=1)
    assert (outcome.compared, outcome.differing, outcome.first, outcome.complete) == (CYCLES, 0, None, True)
    assert rerun(recorded, jobs=2).compared == CYCLES


@pytest.mark.parametrize(("first", "last", "count"), [(0, 0, 1), (57, None, CYCLES - 57), (101, 101, 1), (99, 150, 52)])
def test_a_log_replays_from_any_tick(recorded: Path, first: int, last: int | None, count: int) -> None:
    outcome = rerun(recorded, first=first, last=last)
    assert (outcome.compared, outcome.first) == (count, None)


def test_replaying_from_a_tick_starts_from_the_last_state_before_it(recorded: Path, tmp_path: Path) -> None:
    """Records before that state are not needed, and may be wrong."""

    def spoil(topic: str, data: bytes) -> bytes | None:
        if topic == CYCLE.topic and json.loads(data)["tick"] < 100:
            return None
        return data

    cut = rewritten(recorded, tmp_path / "late.mcap", spoil)
    outcome = rerun(cut)
    assert (outcome.compared, outcome.first) == (CYCLES - 100, None)


def changed(field: str) -> Change:
    """A rewriter that changes a number of cycle 120 by its last bit."""

    def change(topic: str, data: bytes) -> bytes:
        if topic != CYCLE.topic or json.loads(data)["tick"] != 120:
            return data
        record = json.loads(data)
        owner, name = record, field
        if "." in field:
            section, name = field.split(".")
            owner = record[section]
        values = owner[name]
        values[0] = float(np.nextafter(values[0], 1.0))
        return CycleRecord.model_validate(record).model_dump_json().encode()

    return change


@pytest.mark.parametrize("field", ["command.displacement", "model.position", "tension_estimate"])
def test_one_changed_bit_of_an_output_is_found_and_named_with_both_values(
    recorded: Path, tmp_path: Path, field: str
) -> None:
    spoiled = rewritten(recorded, tmp_path / "spoiled.mcap", changed(field))
    outcome = rerun(spoiled)
    assert outcome.first is not None
    assert (outcome.differing, outcome.first.tick) == (1, 120)
    (found,) = outcome.first.fields
    assert found.path == f"{field}[0]"
    assert found.logged == np.nextafter(found.replayed, 1.0)
    assert rerun(spoiled, tolerance=1e-9).first is None


def test_a_changed_input_changes_everything_from_that_cycle_on(recorded: Path, tmp_path: Path) -> None:
    def change(topic: str, data: bytes) -> bytes:
        record = json.loads(data)
        if topic != CYCLE.topic or record["tick"] != 120:
            return data
        record["inputs"]["pose"]["position"][0] += 0.002
        return CycleRecord.model_validate(record).model_dump_json().encode()

    outcome = rerun(rewritten(recorded, tmp_path / "spoiled.mcap", change), tolerance=1e-9)
    assert outcome.first is not None
    assert outcome.first.tick == 120
    assert outcome.differing > 10


def test_a_state_in_the_log_that_is_not_the_one_reached_is_a_difference(recorded: Path, tmp_path: Path) -> None:
    def change(topic: str, data: bytes) -> bytes:
        snapshot = json.loads(data)
        if topic != STATE.topic or snapshot["tick"] != 100:
            return data
        state = json.loads(snapshot["state"])
        state["pose_interval"] += 1
        return StateSnapshot(tick=100, state=json.dumps(state)).model_dump_json().encode()

    outcome = rerun(rewritten(recorded, tmp_path / "spoiled.mcap", change))
    assert outcome.first is not None
    assert outcome.first.tick == 99
    assert [field.path for field in outcome.first.fields] == ["state.pose_interval"]


def test_a_dropped_cycle_is_named_and_the_replay_goes_on_at_the_next_state(recorded: Path, tmp_path: Path) -> None:
    def drop(topic: str, data: bytes) -> bytes | None:
        return None if topic == CYCLE.topic and json.loads(data)["tick"] in (40, 41) else data

    outcome = rerun(rewritten(recorded, tmp_path / "gap.mcap", drop))
    assert outcome.gaps.missing == [(40, 41)]
    assert outcome.gaps.passed_over == 100 - 42
    assert (outcome.compared, outcome.first) == (CYCLES - 60, None)


def test_a_file_whose_writer_was_killed_replays_up_to_its_end(recorded: Path, tmp_path: Path) -> None:
    cut = tmp_path / "cut.mcap"
    data = recorded.read_bytes()
    cut.write_bytes(data[: len(data) * 2 // 3])
    outcome = rerun(cut)
    assert 20 < outcome.compared < CYCLES
    assert (outcome.first, outcome.complete) == (None, False)


@pytest.mark.parametrize("given", [0, 1, 2])
def test_a_rotated_set_replays_as_one_log_from_any_of_its_parts(recorded: Path, tmp_path: Path, given: int) -> None:
    parts = write_parts(recorded, tmp_path, (70, 130))
    shutil.copy(NORMAL, tmp_path / "one-004.mcap")  # of another run, whatever its name says
    outcome = rerun(parts[given])
    assert (outcome.compared, outcome.first) == (CYCLES, None)
    assert len(load(parts[given])) == CYCLES


def test_comparing_no_cycle_is_an_error(recorded: Path, tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no cycle could be compared: the log has no cycle between 5000 and its end"):
        rerun(recorded, first=5000)
    none = rewritten(recorded, tmp_path / "none.mcap", lambda topic, data: None)
    with pytest.raises(LogError, match="contains no cycles"):
        rerun(none)
    no_state = rewritten(
        recorded,
        tmp_path / "no_state.mcap",
        lambda topic, data: data if topic == CYCLE.topic and json.loads(data)["tick"] > 0 else None,
    )
    with pytest.raises(LogError, match="no cycle could be compared"):
        rerun(no_state)


def test_the_command_says_equal_and_exits_0_or_differing_and_exits_1(recorded: Path, tmp_path: Path) -> None:
    result = run_command("replay", str(recorded))
    assert result.returncode == 0, result.stderr
    assert f"{CYCLES} cycles (1.9 s) replayed: bit-identical" in result.stdout
    spoiled = rewritten(recorded, tmp_path / "spoiled.mcap", changed("command.displacement"))
    result = run_command("replay", str(spoiled))
    assert result.returncode == 1
    assert "first differing cycle: 120" in result.stdout
    assert "command.displacement[0]: " in result.stdout
    assert "Traceback" not in result.stderr


def test_a_change_of_version_or_parameters_is_named(recorded: Path, tmp_path: Path) -> None:
    run = open_run(recorded)
    assert (version_changes(run), parameter_changes(run)) == ([], [])
    attached = json.loads(run.attachment)
    del attached["limits"]["limit_time"]
    other = open_run(
        rewritten(recorded, tmp_path / "a.mcap", metadata={"numba": "0.1", "cpu": "i386"}, config=json.dumps(attached))
    )
    lines = version_changes(other)
    assert any(line.endswith("0.1 in the log") and line.startswith("numba is ") for line in lines)
    assert any("processor is " in line and "i386 in the log" in line for line in lines)
    assert parameter_changes(other) == ["limits.limit_time is not in the log's configuration: taken as 1.0"]


def test_fields_are_compared_one_by_one() -> None:
    one, other = '{"a":[1.0,2.0],"b":"x","c":0.0}', '{"a":[1.0,2.5],"b":"x","c":-0.0,"d":1}'
    assert compare(one, other) == (Field("a[1]", 2.0, 2.5), Field("c", 0.0, -0.0), Field("d", "(not there)", 1))
    assert compare(one, other, 0.3) == (Field("d", "(not there)", 1),)
    assert compare('{"n":1}', '{"n":2}', 10.0) == (Field("n", 1, 2),)


def test_the_snapshots_are_a_second_apart(recorded: Path) -> None:
    found = [tick for topic, message in open_run(recorded).messages((STATE.topic,))
             for tick in (json.loads(message.data)["tick"],)]  # fmt: skip
    assert found == [0, 100]
    assert any(True for _ in mcap_records(recorded, (STATE.topic,)))


def test_a_replay_costs_little_more_than_the_cycles_themselves() -> None:
    """Reading, parsing, writing and comparing of records: a ratio within one run, of the best of three rounds."""
    alone, *replays = bench_replay(2.0)
    assert replays[0].cycle_us < 2.5 * alone.cycle_us  # 1.3 on an idle machine
    assert alone.speed > 0.0


def test_the_inputs_of_a_record_are_found_without_the_rest(recorded: Path) -> None:
    for _, message in open_run(recorded).messages((CYCLE.topic,)):
        record = CycleRecord.model_validate_json(message.data)
        assert inputs_of(message.data) == record.inputs
        nasty = record.model_copy(update={"reason": ',"inputs":{}', "reply": '\\","rejected":['})
        assert inputs_of(nasty.model_dump_json().encode()) == record.inputs
        spaced = json.dumps(json.loads(message.data)).encode()
        assert inputs_of(spaced) == record.inputs
