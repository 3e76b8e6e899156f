"""`tendond log smooth` on a run in lockstep: a weight comes onto the tip of a robot that is softer than its model."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.daemon.recording.channels import CYCLE
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.lockstep import watched_loop, without_probe
from tendond.offline.logs.log import load
from tendond.offline.smoothing.smooth import estimator_of
from tendond.offline.smoothing.stretches import BEFORE, stretches
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.cli.commands import few_lines, tendond
from tests.unit.logs.logs import rewritten

CONFIG = without_probe(
    parse_config(
        """\
[control]
solver = "general"
[observer]
stamps = true
pose_noise = 2e-4
[simulator]
solver = "general"
rod = { youngs_modulus = 195e9 }
mocap = { noise = 2e-4, rotation_noise = 5e-3, latency = 0.02 }
weight = { mass = 0.02, time = 1.2, force_only = true }
[log]
idle_period = 0.0
[[sensors]]
name = "skin"
kind = "markers"
at = [0.2, 0.35]
noise = 2e-4
""",
        "test",
    )
)
ARM, STOP, CYCLES = 70, 220, 260


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run: rest, arm, track, stop."""
    path = tmp_path_factory.mktemp("smooth") / "run.mcap"
    setup = CycleSetup.from_config(CONFIG)
    with RunLog(path, CONFIG, setup.rod, now=lambda: 1_700_000_000_000_000_000, queue=100_000) as run_log:
        run_log.state(initial_state(setup))
        states: list[CycleState] = []
        requests = {ARM: ControlAction.ARM, STOP: ControlAction.STOP}
        for watched in watched_loop(CONFIG, CYCLES, requests, see_state=states.append):
            run_log.cycle(watched.record, None, states[-1].rod, watched.truth)
    assert not run_log.error
    return path


def table_of(path: Path) -> dict[str, np.ndarray]:
    """Columns of a CSV file by name."""
    with path.open(encoding="utf-8", newline="") as stream:
        names, *rows = csv.reader(stream)
    return dict(zip(names, np.array(rows, dtype=float).T, strict=True))


def xyz(table: dict[str, np.ndarray], name: str, unit: str) -> np.ndarray:
    """A vector's columns, shape (cycles, 3)."""
    return np.stack([table[f"{name}_{axis}_{unit}"] for axis in "xyz"], axis=1)


def test_tip_and_load_are_found_within_their_bands(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ended = tendond(capsys, "log", "smooth", str(log), "--out", str(tmp_path / "out.csv"))
    assert ended.status == 0, ended.said
    table, run = table_of(tmp_path / "out.csv"), load(log)
    ticks = table["tick"].astype(int)
    assert ticks[0] == ARM - round(BEFORE / CONFIG.loop.period)
    truth = [run.truth[tick] for tick in ticks]
    off = xyz(table, "tip", "m") - np.array([one.position for one in truth])
    assert np.mean(np.abs(off) < 1.96 * xyz(table, "deviation_tip", "m")) > 0.9
    assert np.sqrt(np.mean(off**2)) < CONFIG.observer.pose_noise
    force = np.array([one.tip_force for one in truth])
    apart = [float(np.sqrt(np.mean((xyz(table, name, "N") - force) ** 2))) for name in ("force", "forward_force")]
    assert apart[0] < 0.3 * apart[1]
    late = ticks > ARM + 100
    held = np.abs(xyz(table, "force", "N") - force)[late] < 3.0 * xyz(table, "deviation_force", "N")[late]
    assert held.mean() > 0.9
    said = "load        came, went or changed at 1.20 s"  # `simulator.weight.time`
    for words in ("consistency", said, "stiffness", str(tmp_path / "out.csv"), str(tmp_path / "out.png")):
        assert words in ended.out
    assert (tmp_path / "out.png").stat().st_size > 10_000


def test_an_npz_has_the_arrays_of_the_table(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    short = rewritten(log, tmp_path / "short.mcap", lambda topic, data: data if _tick(topic, data) < ARM + 30 else None)
    for name in ("a.npz", "a.csv"):
        assert tendond(capsys, "log", "smooth", str(short), "--out", str(tmp_path / name)).status == 0
    table = table_of(tmp_path / "a.csv")
    with np.load(tmp_path / "a.npz") as arrays:
        np.testing.assert_array_equal(arrays["error.moment"][:, 1], table["error_moment_1_N_m"])
        np.testing.assert_array_equal(arrays["deviation.force"], xyz(table, "deviation_force", "N"))
        units = json.loads(str(arrays["units"]))
    assert units["tip"] == "m"
    assert units["error.moment"] == "N m"


def test_json_says_what_was_found(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    short = rewritten(log, tmp_path / "short.mcap", lambda topic, data: data if _tick(topic, data) < ARM + 30 else None)
    found = json.loads(tendond(capsys, "log", "smooth", str(short), "--json").out)
    (stretch,) = found["stretches"]
    assert stretch["last"] == ARM + 29
    assert 0.5 < stretch["consistency"] < 2.0
    assert stretch["residual_mm"] < stretch["innovation_mm"]
    assert found["table"] == str(tmp_path / "short-smoothed.csv")


def test_what_cannot_be_smoothed_is_said_in_a_line(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    idle = rewritten(log, tmp_path / "idle.mcap", lambda topic, data: data if _tick(topic, data) < ARM else None)
    probed = rewritten(log, tmp_path / "probed.mcap", lambda topic, data: _probing(topic, data))
    blind = rewritten(log, tmp_path / "blind.mcap", lambda topic, data: _without_pose(topic, data))
    bare = rewritten(log, tmp_path / "bare.mcap", attach=False)
    for arguments, words in (
        ((str(idle),), "never armed"),
        ((str(probed),), "only probed"),
        ((str(blind),), "no pose was admitted"),
        ((str(bare),), "configuration"),
        ((str(log), "--out", str(tmp_path / "out.txt")), "end it in .csv, .parquet, .npz"),
        ((str(log), "--set", "observer.pose_noise=-1"), "pose_noise"),
    ):
        ended = tendond(capsys, "log", "smooth", *arguments)
        assert ended.status != 0
        assert words in ended.said
        assert few_lines(ended.said)


def _tick(topic: str, data: bytes) -> int:
    return int(json.loads(data)["tick"]) if topic == CYCLE.topic else -1


def _probing(topic: str, data: bytes) -> bytes | None:
    """The log of an arm that was stopped in the probe."""
    if topic != CYCLE.topic:
        return data
    record = CycleRecord.model_validate_json(data)
    if record.tick >= ARM + 20:
        return None
    return data if record.tick < ARM else record.model_copy(update={"mode": Mode.PROBE}).model_dump_json().encode()


def _without_pose(topic: str, data: bytes) -> bytes:
    if topic != CYCLE.topic:
        return data
    record = CycleRecord.model_validate_json(data)
    return (
        record.model_copy(update={"inputs": record.inputs.model_copy(update={"pose": None})}).model_dump_json().encode()
    )


@pytest.fixture(scope="module")
def records(log: Path) -> list[CycleRecord]:
    return load(log).records


def test_readings_have_the_ages_of_their_stamps_and_those_refused_are_left_out(records: list[CycleRecord]) -> None:
    refused = records[ARM].model_copy(update={"rejected": ("sensor skin: out of order",)})
    (stretch,) = stretches(CONFIG, [*records[:ARM], refused, *records[ARM + 1 :]])
    first = stretch.instants[0].tick
    assert first is not None
    ages = {reading.age for one in stretch.instants for reading in one.readings if reading.sensor == 0}
    assert {round(age, 9) for age in ages} == {0.02}
    without = [one.tick for one in stretch.instants if all(reading.sensor == 0 for reading in one.readings)]
    assert without == [ARM]


def test_a_missed_period_is_a_step_without_readings_and_a_missing_cycle_ends_a_stretch(
    records: list[CycleRecord],
) -> None:
    at = ARM + 40
    late = records[at].model_copy(update={"inputs": records[at].inputs.model_copy(update={"missed_ticks": 2})})
    (whole,) = stretches(CONFIG, records)
    (longer,) = stretches(CONFIG, [*records[:at], late, *records[at + 1 :]])
    assert len(longer.instants) == len(whole.instants) + 2
    between = [one for one in longer.instants if one.tick is None]
    np.testing.assert_allclose([one.time for one in between], [records[at].time + d for d in (0.0, 0.01)], atol=1e-9)
    assert all(one.tensions.tolist() == list(records[at - 1].tension_estimate) for one in between)
    assert longer.instants[-1].time == pytest.approx(whole.instants[-1].time + 0.02)
    first, second = stretches(CONFIG, [*records[:at], *records[at + 1 :]])
    assert (first.instants[-1].tick, second.instants[0].tick) == (at - 1, at + 1)
    assert second.before.tolist() == list(records[at + 1].tension_estimate)


def test_any_observers_log_is_smoothed_with_the_general_rod(records: list[CycleRecord]) -> None:
    config = RigConfig.model_validate({"observer": {"kind": "force", "delay": 0.03}, "control": {"solver": "shooting"}})
    estimator = estimator_of(config, "run.mcap")
    assert estimator.rod.time_step == config.loop.period
    assert len(estimator.sensors) == 1
