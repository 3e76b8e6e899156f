"""A run in lockstep with sensors: its log replays to the last bit, and the tools for logs name the readings."""

import csv
from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.lockstep import watched_loop, without_probe
from tendond.offline.logs import load
from tendond.offline.logs.export import export
from tendond.offline.logs.info import info
from tendond.offline.replay.rerun import rerun
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.cli.commands import tendond
from tests.unit.sensors.test_sensor_config import GOOD

CYCLES = 230
CONFIG = without_probe(parse_config("[observer]\nstamps = true\n[simulator.mocap]\nlatency = 0.01\n" + GOOD, "t"))


def recorded(path: Path, config: RigConfig) -> list[CycleRecord]:
    """Run in lockstep into a log; some cycles lack rows or readings, others have what is refused."""
    setup = CycleSetup.from_config(config)
    state, records = initial_state(setup), []
    now_ns = [1_700_000_000_000_000_000]
    with RunLog(path, config, setup.rod, now=lambda: now_ns[0], queue=100_000) as run_log:
        run_log.state(state)
        for tick, watched in enumerate(watched_loop(config, CYCLES, {5: ControlAction.ARM})):
            inputs = watched.record.inputs
            readings = dict(inputs.readings)
            if tick % 7 == 3:
                skin = readings["skin"]
                readings["skin"] = skin.model_copy(update={"rows": (None, *skin.rows[1:])})
            elif tick % 7 == 4:
                readings["skin"] = readings["skin"].model_copy(update={"seq": 0})
            elif 100 <= tick < 125:
                readings.pop("imu")
            changed = inputs.model_copy(update={"readings": readings})
            state, _, record = step(setup, state, changed)
            now_ns[0] += 10_000_000
            run_log.cycle(record, None, state.rod, watched.truth)
            run_log.state(state)
            records.append(record)
    assert not run_log.error
    return records


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[CycleRecord]]:
    path = tmp_path_factory.mktemp("log") / "run.mcap"
    return path, recorded(path, CONFIG)


def test_a_run_with_sensors_replays_to_the_last_bit_from_its_beginning_and_from_a_state_in_it(
    log: tuple[Path, list[CycleRecord]],
) -> None:
    path, records = log
    assert records[-1].mode is Mode.TRACKING
    assert {len(record.inputs.readings) for record in records[10:]} == {3, 4, 5}  # the gratings come at 50 Hz
    assert any("sensor skin: out of order" in record.rejected for record in records)
    for first in (0, 120):
        outcome = rerun(path, first=first, jobs=1)
        assert (outcome.compared, outcome.first) == (CYCLES - first, None)


def test_the_arrays_of_a_log_have_each_row_of_a_reading_with_its_unit(log: tuple[Path, list[CycleRecord]]) -> None:
    path, records = log
    run = load(path)
    marker = run["inputs.readings.skin.rows.0"]
    assert marker.shape == (CYCLES, 3)
    assert np.isnan(marker[10]).all()  # 10 % 7 == 3: it is not seen
    reading = records[50].inputs.readings["skin"]
    assert marker[50].tolist() == list(reading.rows[0] or ())
    units = {name.removeprefix("inputs."): unit for name, unit in run.units.items() if "reading" in name}
    assert units["readings.skin.rows.2"] == "m"
    assert units["readings.gratings.rows.1"] == "1/m"
    assert units["readings.cells.rows.0"] == "N"
    assert units["readings.imu.rows.0"] == ""
    assert units["reading_lags.skin"] == "s"
    assert run["inputs.reading_lags.skin"][50] == pytest.approx(0.01)


def test_info_and_export_name_the_readings(log: tuple[Path, list[CycleRecord]], tmp_path: Path) -> None:
    path, records = log
    told = info(path)
    assert told["readings"] == {
        name: sum(name in record.inputs.readings for record in records)
        for name in ("skin", "gratings", "cells", "imu", "vehicle")
    }
    export(load(path), tmp_path / "run.csv")
    with (tmp_path / "run.csv").open() as stream:
        row = list(csv.DictReader(stream))[50]
    reading = records[50].inputs.readings.get("gratings")
    assert float(row["inputs_readings_cells_rows_0_0_N"]) == (records[50].inputs.readings["cells"].rows[0] or (0.0,))[0]
    assert bool(row["inputs_readings_gratings_rows_0_0_1_per_m"]) == (reading is not None)


@pytest.mark.parametrize("command", ["log info", "log plot", "log report", "log compare"])
def test_the_commands_for_logs_take_one_with_sensors(
    command: str, log: tuple[Path, list[CycleRecord]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, _ = log
    both = [str(path), str(path)] if command.endswith("compare") else [str(path)]
    out = [] if command.endswith("info") else ["--out", str(tmp_path / "out")]
    done = tendond(capsys, *command.split(), *both, *out)
    assert done.status == 0, done.said
