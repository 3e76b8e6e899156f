"""`tendond log`, `compare`, `plot` and what reads logs: contents, repair, tables; bad files are one line and exit 2."""

import csv
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any, get_args
from unittest import mock

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from pydantic import BaseModel

from tendond.cli.app import main
from tendond.daemon.errors import UsageError
from tendond.daemon.recording.channels import CYCLE, STATE
from tendond.offline.logs import load
from tendond.offline.logs.container import LogError
from tendond.offline.logs.export import export
from tendond.offline.logs.info import info
from tendond.offline.logs.log import load as load_log
from tendond.offline.logs.recover import recover
from tendond.offline.logs.units import UNITS, column_name, components
from tendond.schemas.record import CycleRecord
from tests.golden.scripts import CYCLES, FOLDER
from tests.rig.servos import calibration
from tests.unit.offline.logs import rewritten

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


@dataclass(frozen=True)
class Said:
    """What a command has printed, and its exit status."""

    returncode: int
    stdout: str
    stderr: str


def run_command(*arguments: str) -> Said:
    """The program, from its entry point, in this process."""
    out, err, code = StringIO(), StringIO(), 0
    with redirect_stdout(out), redirect_stderr(err), mock.patch.object(sys, "argv", ["tendond", *arguments]):
        try:
            main()
        except SystemExit as end:
            code = end.code if isinstance(end.code, int) else 0
    return Said(code, out.getvalue(), err.getvalue())


def damaged(path: Path, out: Path) -> Path:
    """A copy with a flipped bit in its largest chunk that is not the first."""
    data = bytearray(path.read_bytes())
    data[len(data) * 2 // 3] ^= 0x10
    out.write_bytes(data)
    return out


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
    assert "is there already; choose another file" in again.stderr


def test_what_is_whole_is_recovered_without_loss(tmp_path: Path) -> None:
    found = recover(NORMAL, tmp_path / "new.mcap")
    assert (found.damage, found.missing, found.cycles) == ([], [], CYCLES)
    with (tmp_path / "new.mcap").open("rb") as stream:
        reader = make_reader(stream, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == found.messages == sum(1 for _ in reader.iter_messages())


def test_arrays_are_the_records_with_units() -> None:
    run, records = load(NORMAL), load_log(NORMAL).records
    assert len(run) == CYCLES
    np.testing.assert_array_equal(run["tick"], np.arange(CYCLES))
    np.testing.assert_array_equal(run["command.displacement"], [record.command.displacement for record in records])
    assert run["command.displacement"].shape == (CYCLES, 4)
    assert (run.units["command.displacement"], run.units["estimate.velocity"], run.units["mode"]) == ("m", "m/s", "")
    assert list(run["mode"]) == [record.mode.value for record in records]
    assert np.isnan(run["terms.z1"][0]).all()
    np.testing.assert_array_equal(run["terms.z1"][30], records[30].terms["z1"])
    np.testing.assert_array_equal(run["truth.position"][:, 0], [truth.position[0] for truth in load_log(NORMAL).truth])
    with pytest.raises(KeyError, match=r"'nothing' is not in .*normal.mcap; it has log_time_ns, tick"):
        run["nothing"]


def number_fields(model: type[BaseModel], path: str = "") -> list[str]:
    """Paths of all fields of a record that hold floating-point numbers."""
    found = []
    for name, field in model.model_fields.items():
        for part in (field.annotation, *get_args(field.annotation)):
            if isinstance(part, type) and issubclass(part, BaseModel):
                found += number_fields(part, f"{path}{name}.")
                break
        else:
            if "float" in str(field.annotation):
                found.append(path + name)
    return found


def test_every_number_of_a_record_has_its_unit() -> None:
    """A new field of the record needs a line in UNITS, unless it has none."""
    without = {"terms", "law_state", "inputs.pose.orientation", "model.orientation"}
    for name in number_fields(CycleRecord):
        if name not in without and not name.startswith("inputs.reference"):
            assert name.rsplit(".", 1)[-1] in UNITS, name


def test_columns_name_component_and_unit() -> None:
    assert column_name("time") == "time_s"
    assert column_name("estimate.acceleration", "x") == "estimate_acceleration_x_m_per_s2"
    assert column_name("timing.work_us") == "timing_work_us"
    assert components("model.orientation", 4) == ["w", "x", "y", "z"]
    assert components("tension", 3) == ["0", "1", "2"]
    assert components("measured", 3) == ["x", "y", "z"]


def test_csv_keeps_every_digit(tmp_path: Path) -> None:
    run = load(NORMAL)
    count = export(run, tmp_path / "run.csv")
    with (tmp_path / "run.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert (len(rows), len(rows[0])) == (CYCLES, count)
    assert [float(row["command_displacement_0_m"]) for row in rows] == run["command.displacement"][:, 0].tolist()
    assert rows[0]["terms_z1_0_m"] == ""
    assert {row["mode"] for row in rows} == {"idle", "pretension", "tracking", "releasing"}


def test_parquet_keeps_every_digit(tmp_path: Path) -> None:
    pq: Any = pytest.importorskip("pyarrow.parquet")
    run = load(NORMAL)
    export(run, tmp_path / "run.parquet")
    table = pq.read_table(tmp_path / "run.parquet")
    assert table.column("command_displacement_0_m").to_pylist() == run["command.displacement"][:, 0].tolist()
    assert table.column("terms_z1_0_m").null_count == int(np.isnan(run["terms.z1"][:, 0]).sum())
    assert table.schema.metadata[b"tendond.rig"] == b"paper"


def test_a_table_of_another_kind_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"end it in .csv or .parquet"):
        export(load(NORMAL), tmp_path / "run.xlsx")


def something_else(path: Path) -> None:
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        writer.finish()


def future(path: Path) -> None:
    def change(topic: str, data: bytes) -> bytes:
        return data.replace(b'{"version":2,', b'{"version":99,', 1) if topic == CYCLE.topic else data

    rewritten(NORMAL, path, change)


def future_state(path: Path) -> None:
    def change(topic: str, data: bytes) -> bytes:
        return data.replace(b'{"version":2,', b'{"version":99,', 1) if topic == STATE.topic else data

    rewritten(NORMAL, path, change)


BAD = {
    "no-mcap": (lambda path: path.write_bytes(b"time,x\n0,1\n" * 9), "is not an MCAP file"),
    "empty": (lambda path: path.write_bytes(b""), "is not an MCAP file"),
    "else": (something_else, "is an MCAP file, but not a log of tendond"),
    "no-cycles": (lambda path: rewritten(NORMAL, path, lambda topic, data: None), "contains no cycles"),
    "no-attachment": (lambda path: rewritten(NORMAL, path, attach=False), "has no configuration ('rig.json')"),
    "damaged": (lambda path: damaged(NORMAL, path), "'tendond log recover"),
    "future": (future, "read the log with the version of tendond that wrote it"),
    "future-state": (future_state, "message on 'state': version = 99"),
    "future-configuration": (
        lambda path: rewritten(NORMAL, path, config='{"rig": {"colour": "red"}}'),
        "rig.json: rig.colour: unknown key",
    ),
    "future-calibration": (
        lambda path: rewritten(NORMAL, path, calibration='{"version": 99}'),
        "calibration.json: version = 99",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_log_is_one_line_for_whatever_reads_it(tmp_path: Path, name: str) -> None:
    from tendond.offline.replay.rerun import rerun

    make, message = BAD[name]
    path = tmp_path / "a.mcap"
    make(path)  # type: ignore[no-untyped-call]
    for read in (rerun,) if name == "future-state" else (load, load_log, rerun):
        with pytest.raises(LogError) as caught:
            read(path)
        assert message in str(caught.value), read
        assert "\n" not in str(caught.value)
        assert isinstance(caught.value, UsageError)  # exit status 2


COMMANDS = {
    "replay": ("replay",),
    "variant": ("log", "what-if", "--law", "sliding_mode"),
    "closed-loop": ("log", "what-if", "--closed-loop"),
    "info": ("log", "info"),
    "recover": ("log", "recover"),
    "export": ("log", "export"),
    "compare": ("log", "compare"),
    "plot": ("plot",),
    "report": ("log", "report"),
    "view": ("log", "view"),
}
WORKS = {  # health is what `log info` is for, and repair what `log recover` is for
    *(("info", "damaged"), ("recover", "damaged"), ("recover", "no-attachment"), ("recover", "future")),
    *(("recover", "future-configuration"), ("recover", "future-calibration"), ("recover", "future-state")),
    *(("view", "damaged"), ("view", "future"), ("view", "future-state")),  # serves until then
    *((command, "future-state") for command in ("info", "export", "compare", "plot", "report", "variant")),
    ("closed-loop", "future-state"),
}


@pytest.mark.parametrize("name", BAD)
def test_every_command_refuses_a_bad_log_in_one_line_with_exit_status_2(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.mcap"
    make, message = BAD[name]
    make(path)  # type: ignore[no-untyped-call]
    for command, arguments in COMMANDS.items():
        if (command, name) in WORKS:
            continue
        result = run_command(*arguments, str(path))
        assert result.returncode == 2, (command, result)
        assert result.stderr.count("\n") == 1, (command, result)
        assert result.stderr.startswith(f"tendond: {path}: "), (command, result)
        nothing = command == "recover" and name in ("else", "no-cycles")
        assert ("nothing in it is whole" if nothing else message) in result.stderr, (command, result)
        assert {file.name for file in tmp_path.iterdir()} == {"a.mcap"}, command


@pytest.mark.parametrize("name", ["damaged", "future-state"])
def test_what_a_command_does_not_need_may_be_bad(tmp_path: Path, name: str) -> None:
    make, _ = BAD[name]
    make(tmp_path / "a.mcap")  # type: ignore[no-untyped-call]
    for command in ("info", "recover"):
        result = run_command(*COMMANDS[command], str(tmp_path / "a.mcap"))
        assert (result.returncode, result.stderr) == (0, ""), (command, result)


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
