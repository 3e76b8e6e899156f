"""The paper's metrics, and reading whole, cut and foreign logs."""

import json
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from rich.console import Console

from tendond.daemon.recording import foxglove
from tendond.daemon.recording.channels import CYCLE, LOG, TRUTH
from tendond.daemon.recording.recorder import Recorder
from tendond.daemon.recording.run_files import CONFIG
from tendond.offline.logs.container import LogError
from tendond.offline.logs.log import LogFile, load
from tendond.offline.logs.metrics import tracking
from tendond.offline.logs.summary import summary, table, write_summary
from tendond.offline.paper.published import SIMULATION
from tendond.offline.plots.figures import NAMES, draw
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, SimulatorTruth
from tendond.schemas.record import CycleRecord
from tests.unit.offline.records import TARGET, ZERO, cycle_record, write_log


def run() -> list[CycleRecord]:
    """Idle, tracking towards 0.34 m for 60 cycles, releasing, tracking again."""
    records = [cycle_record(tick, (-0.02, 0.0, 0.5), Mode.IDLE, 0.0) for tick in range(10)]
    for i in range(60):
        part = 1.0 - 0.8**i
        x, z = 0.34 * (part + 0.5 * 0.9**i * part), 0.5 - 0.46 * part
        records.append(cycle_record(10 + i, (x, 0.0, z), Mode.TRACKING, 0.058 * part))
    records += [cycle_record(70 + i, (0.3, 0.0, 0.1), Mode.RELEASING, 0.02) for i in range(5)]
    return records + [cycle_record(75 + i, (0.0, 0.0, 0.5), Mode.TRACKING, 0.0) for i in range(5)]


@pytest.fixture
def log(tmp_path: Path) -> LogFile:
    return load(write_log(tmp_path / "run.mcap", run()))


def test_a_log_gives_back_what_was_recorded(tmp_path: Path) -> None:
    truth = SimulatorTruth(
        seq=0, stamp_ns=0, position=ZERO, velocity=ZERO, displacement=(0.0,), tension=(0.0,), tip_force=ZERO
    )
    said = foxglove.log_line(3, foxglove.LogLevel.WARNING, "late")
    config = RigConfig.model_validate({"rig": {"name": "left"}, "rod": {"nodes": 50}})
    with Recorder(tmp_path / "a.mcap", {"x": "y"}, {CONFIG: config.model_dump_json()}, 100) as recorder:
        recorder.put(CYCLE, 0, cycle_record(0))
        recorder.put(TRUTH, 0, truth)
        recorder.put(LOG, 0, said)
    log = load(recorder.path)
    assert (log.config, log.metadata, log.complete) == (config, {"x": "y", "part": "0"}, True)
    assert (log.records, log.truth, log.log_lines) == ([cycle_record(0)], [truth], [said])
    assert (log.timings, log.shapes) == ([], [])


def test_a_shape_keeps_its_tick_its_ends_and_its_micrometres(log: LogFile) -> None:
    assert [tick for tick, _ in log.shapes] == list(range(0, 80, 5))
    tick, points = log.shapes[4]
    assert points.shape == (50, 3)
    np.testing.assert_array_equal(points[0], ZERO)
    np.testing.assert_allclose(points[-1], run()[tick].measured or ZERO, atol=0.5e-6)


def test_tracking_is_the_first_stretch_from_the_tip_as_it_was_when_tracking_began(log: LogFile) -> None:
    found = tracking(log)
    assert list(found.ticks) == list(range(10, 70))
    np.testing.assert_array_equal(found.tip, [record.measured for record in run()[10:70]])
    np.testing.assert_allclose(found.time, 0.01 * np.arange(60))
    assert (found.target, found.axis) == (TARGET, 0)


def test_a_summary_has_its_keys_and_nothing_else(log: LogFile, tmp_path: Path) -> None:
    values = write_summary(log, tmp_path / "out" / "summary.json")
    assert json.loads((tmp_path / "out" / "summary.json").read_text()) == values == summary(log)
    assert list(values) == [
        *("tpl_mm", "settling_iterations", "overshoot_percent", "rise_iterations", "steady_state_error_mm"),
        *("final_tip_m", "final_displacement_m", "settling_s", "path_mm", "path_overshoot_percent", "iae_mm_s"),
        *("ripple_mm", "tendon_rate_mm_s", "peak_tension_n", "min_tension_n"),
        *("recoveries", "cycles", "missed_ticks", "cycle_ms_median", "cycle_ms_p99"),
    ]
    assert (values["cycles"], values["missed_ticks"]) == (80, 80)
    assert values["cycle_ms_median"] == pytest.approx(1.0395)
    assert values["cycle_ms_p99"] == pytest.approx(1.07821)
    assert values["final_displacement_m"] == pytest.approx(0.058, rel=1e-4)
    assert values["final_tip_m"] == list(run()[69].measured or ZERO)


def test_the_table_shows_the_papers_numbers_where_it_has_the_law(log: LogFile) -> None:
    console = Console(width=100, record=True, file=StringIO())
    for law in (*SIMULATION, "other"):
        console.print(table(summary(log), law, SIMULATION.get(law)))
    text = console.export_text()
    assert "407.8" in text
    assert "1300.1" in text
    assert text.count("paper") == 2 * len(SIMULATION)  # a column and a caption each


def test_figures_are_drawn(log: LogFile, tmp_path: Path) -> None:
    paths = draw(log, tmp_path / "out")
    assert [path.name for path in paths] == [f"run{number}-{name}.png" for number in (1, 2) for name in NAMES]
    assert all(path.read_bytes().startswith(b"\x89PNG") and path.stat().st_size > 10_000 for path in paths)


def test_figures_are_drawn_of_a_single_cycle_in_the_other_plane(tmp_path: Path) -> None:
    config = RigConfig.model_validate({"control": {"plane": "yz", "agonist": 3}, "reference": {"across": -0.2}})
    log = load(write_log(tmp_path / "run.mcap", [cycle_record(0, target=(0.0, -0.2, 0.3))], config))
    assert [path.stem for path in draw(log, tmp_path)] == [*NAMES]


def fails(path: Path, match: str) -> None:
    with pytest.raises(LogError, match=match) as caught:
        summary(load(path))
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(path))


def bulky() -> list[CycleRecord]:
    """Cycles that fill about ten chunks."""
    random = np.random.default_rng(0)
    return [cycle_record(tick, terms=random.random(200).tolist()) for tick in range(300)]


def test_a_cut_file_is_read_up_to_the_cut(log: LogFile, tmp_path: Path) -> None:
    whole = write_log(tmp_path / "long.mcap", bulky())
    data, cut = whole.read_bytes(), tmp_path / "cut.mcap"
    counts = []
    for size in np.linspace(9, len(data) - 1, 30).astype(int):
        cut.write_bytes(data[:size])
        try:
            read = load(cut)
        except LogError:
            counts.append(0)
            continue
        assert [record.tick for record in read.records] == list(range(len(read.records)))
        assert not read.complete or size > len(data) - 9
        counts.append(len(read.records))
    assert counts == sorted(counts)
    assert len(set(counts)) > 3
    assert counts[-1] == 300


def test_a_damaged_file_is_refused_with_the_command_that_recovers_it(tmp_path: Path) -> None:
    path = write_log(tmp_path / "run.mcap", bulky())
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0xFF
    path.write_bytes(data)
    fails(path, r"damaged chunk \(.*\): \d+ bytes at \d+; 'tendond log recover .*' recovers the intact part")


@pytest.mark.parametrize("content", [b"", b"[rig]\n", b"\x89MCAP0\r\n", b"\x89MCAP0\r\n" + bytes(100)])
def test_a_file_that_is_no_mcap_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.mcap").write_bytes(content)
    fails(tmp_path / "a.mcap", "is not an MCAP file; give a log")


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    fails(tmp_path / "a.mcap", "cannot be read: No such file or directory; check name and permissions")


def test_an_mcap_file_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channel = writer.register_channel("cycle", "json", writer.register_schema("Cycle", "jsonschema", b"{}"))
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()
    fails(path, "is an MCAP file, but not a log of tendond")


@pytest.mark.parametrize(
    ("attachments", "match"),
    [
        ({}, "has no configuration"),
        ({CONFIG: "{"}, "its configuration is not valid JSON"),
        ({CONFIG: '{"rig": {"nam": "a"}}'}, "rig.json: rig.nam: unknown key"),
        ({CONFIG: "{}"}, "contains no cycles"),
    ],
)
def test_a_log_without_configuration_or_cycles_is_refused(
    tmp_path: Path, attachments: dict[str, str], match: str
) -> None:
    with Recorder(tmp_path / "a.mcap", {}, attachments, 10) as recorder:
        pass
    fails(recorder.path, match)


def test_a_log_of_another_version_is_refused(tmp_path: Path) -> None:
    record = cycle_record(0).model_copy(update={"version": 99})
    fails(
        write_log(tmp_path / "a.mcap", [record]), "message on 'cycle': version = 99: .*; read the log with the version"
    )


def test_a_log_in_which_nothing_tracks_has_no_metrics(tmp_path: Path) -> None:
    fails(write_log(tmp_path / "a.mcap", run()[:10]), "contains no cycle in mode 'tracking'; arm")


def test_a_target_of_zero_has_no_metrics(tmp_path: Path) -> None:
    records = [cycle_record(tick, (0.002, 0.0, 0.5), target=(0.0, 0.0, 0.5)) for tick in range(5)]
    fails(write_log(tmp_path / "a.mcap", records), "goes nowhere in x, which the metrics are relative to")
