"""A log as arrays and tables: units, names of columns, every digit."""

import csv
import sys
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from pydantic import BaseModel

from tendond.daemon.errors import UsageError
from tendond.offline.logs import load
from tendond.offline.logs.export import export
from tendond.offline.logs.log import load as load_log
from tendond.offline.logs.units import UNITS, column_name, components
from tendond.schemas.record import CycleRecord
from tests.golden.scripts import CYCLES, FOLDER
from tests.unit.logs.commands import run_command

NORMAL, FAULTS = FOLDER / "normal.mcap", FOLDER / "faults.mcap"


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


@pytest.mark.parametrize(
    ("wrong", "suggested"),
    [
        ("comand.displacement", "did you mean 'command.displacement'"),
        ("displacement", "did you mean 'truth.displacement' or 'command.displacement'"),
        ("command_displacment_0_m", "did you mean 'command_displacement_0_m'"),
        ("nothing at all", "run.names lists all names"),
    ],
)
def test_a_name_that_is_not_in_the_log_is_answered_with_the_nearest(wrong: str, suggested: str) -> None:
    run = load(NORMAL)
    for read in (run.__getitem__, run.to_pandas):
        with pytest.raises(KeyError) as caught:
            read(wrong)
        assert str(caught.value).startswith(f"{NORMAL}: has no '{wrong}'; {suggested}")
        assert isinstance(caught.value, UsageError)


def test_a_column_is_read_by_its_name_too() -> None:
    run = load(NORMAL)
    np.testing.assert_array_equal(run["command_displacement_1_m"], run["command.displacement"][:, 1])


def test_a_data_frame_has_the_columns_of_all_or_of_chosen_names() -> None:
    run = load(NORMAL)
    frame = run.to_pandas()
    assert list(frame) == list(run.columns())
    assert len(frame) == CYCLES
    np.testing.assert_array_equal(frame["measured_x_m"], run["measured"][:, 0])
    chosen = run.to_pandas("time", "command.displacement", "measured_x_m")
    assert list(chosen) == ["time_s", *(f"command_displacement_{i}_m" for i in range(4)), "measured_x_m"]


def test_a_missing_pandas_is_named_with_the_command_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(UsageError, match=r"needs pandas: pip install 'tendond\[notebook\]'"):
        load(NORMAL).to_pandas()


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
    without = {"safety.distance"}  # of a strain it has none
    without |= {"inputs.settings", "tuned"}  # by keys of the configuration, each with its own
    without |= {"terms", "law_state", "inputs.pose.orientation", "model.orientation", "inputs.readings.rows"}
    without |= {f"observer.filter.{name}" for name in ("stiffness", "stiffness_deviation", "consistency")}
    without |= {f"observer.filter.contact.{name}" for name in ("statistic", "onset")}
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
    assert components("observer.filter.tip_covariance", 6) == ["xx", "xy", "xz", "yy", "yz", "zz"]
    assert column_name("observer.filter.bend_error", "0", "N m") == "observer_filter_bend_error_0_N_m"


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


@pytest.mark.parametrize("command", ["export", "smooth"])
def test_parquet_without_pyarrow_is_refused_before_the_log_is_read(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    result = run_command("log", command, str(tmp_path / "none.mcap"), "--out", str(tmp_path / "run.parquet"))
    assert result.returncode == 2
    assert "pip install 'tendond[parquet]'" in result.stderr
