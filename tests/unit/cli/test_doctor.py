"""The doctor's checks of logs, calibrations, kernels, poses and senders."""

import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from typing import Any

import pytest

from tendond.cli.doctor import bus, camera, files
from tendond.cli.doctor.check import CheckOutcome, Rig
from tendond.cli.doctor.listen import BusActivity
from tendond.cli.doctor.report import CHECKS, results_of
from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.schemas.messages import TipPose
from tests.rig.servos import calibration
from tests.unit.cli.computer import Computer


def test_room_and_speed_for_logs_leave_nothing_behind(computer: Computer, monkeypatch: pytest.MonkeyPatch) -> None:
    assert computer.outcome(files.log_speed) in {CheckOutcome.PASS, CheckOutcome.WARN}
    assert not list(computer.folder.iterdir())
    for megabytes, expected in (
        (500.0, CheckOutcome.FAIL),
        (5_000.0, CheckOutcome.WARN),
        (50_000.0, CheckOutcome.PASS),
    ):
        free = type("Usage", (), {"free": megabytes * 1e6})
        monkeypatch.setattr("shutil.disk_usage", lambda folder, free=free: free)
        assert computer.outcome(files.log_space) is expected


def test_calibrations(computer: Computer) -> None:
    assert computer.outcome(files.calibration) is None  # no servos, no calibration
    computer.sections = {"limits": {"displacement_rate": 0.08, "displacement_min": -0.08, "displacement_max": 0.08}}
    computer.sections["servo"] = {}
    assert computer.outcome(files.calibration) is CheckOutcome.FAIL
    for rig, days, expected in (
        ("paper", 1, CheckOutcome.PASS),
        ("paper", 100, CheckOutcome.WARN),
        ("another", 1, CheckOutcome.FAIL),
    ):
        date = (datetime.now(UTC) - timedelta(days=days)).isoformat()
        found = calibration(rig=rig).model_copy(update={"date": date})
        save_calibration(computer.folder / "calibration.json", found)
        assert computer.outcome(files.calibration) is expected


def poses(count: int, every: float, **changes: Any) -> list[tuple[int, TipPose]]:
    """Ten milliseconds old when they come."""
    now = time.monotonic_ns()
    made = []
    for number in range(count):
        arrival = now + round(number * every * 1e9)
        pose = TipPose(
            seq=number, stamp_ns=arrival - 10_000_000, position=(0, 0, 0.5), orientation=(1, 0, 0, 0), **changes
        )
        made.append((arrival, pose))
    return made


@pytest.mark.parametrize(
    ("activity", "expected"),
    [
        (BusActivity(), CheckOutcome.WARN),
        (BusActivity(connected=True), CheckOutcome.FAIL),
        (BusActivity(connected=True, unreadable={"wrong version": 7}), CheckOutcome.FAIL),
        (BusActivity(connected=True, poses=poses(100, 0.01)), CheckOutcome.PASS),
        (BusActivity(connected=True, poses=poses(50, 0.02)), CheckOutcome.WARN),
        (BusActivity(connected=True, poses=poses(100, 0.01, valid=False)), CheckOutcome.FAIL),
        (BusActivity(connected=True, poses=poses(90, 0.01) + poses(10, 0.01, valid=False)), CheckOutcome.WARN),
        (BusActivity(connected=True, poses=poses(2, 0.5)), CheckOutcome.FAIL),
    ],
)
def test_poses_that_were_heard(computer: Computer, activity: BusActivity, expected: CheckOutcome) -> None:
    if len(activity.poses) == 100:
        activity.poses.sort(key=lambda one: one[0])
    rig = computer.rig
    rig.activity = activity
    result = bus.poses(rig)
    assert result.outcome is expected, result


def test_a_check_that_stumbles_does_not_end_the_others(computer: Computer, monkeypatch: pytest.MonkeyPatch) -> None:
    def stumbling(rig: Rig) -> None:
        raise ValueError("of all things")

    monkeypatch.setattr("tendond.cli.doctor.report.CHECKS", {"first": stumbling, "clock": CHECKS["clock"]})
    results = dict(results_of(computer.rig))
    assert results["first"].outcome is CheckOutcome.FAIL
    assert set(results) == {"first", "clock"}


def test_kernels_are_missed_only_where_they_are_not_compiled(
    computer: Computer, monkeypatch: pytest.MonkeyPatch
) -> None:
    from tendond.model.numerics import compile as compiling
    from tendond.model.warm import PARTS

    for part in PARTS.values():
        part(4)
    code = "import tendond.model.rod.rod\nfrom tendond.model.numerics.compile import uncached\nprint(uncached())"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"  # in a process without the kernels that other tests have imported
    monkeypatch.setattr(compiling, "_KERNELS", compiling._KERNELS[:1])
    assert computer.outcome(files.kernels) is CheckOutcome.PASS
    absent: Callable[[], dict[str, str]] = dict
    monkeypatch.setattr(compiling._KERNELS[0]._cache._cache_file, "_load_index", absent)
    result = files.kernels(computer.rig)
    assert result.outcome is CheckOutcome.WARN
    assert compiling._KERNELS[0].py_func.__name__ in result.finding


def test_who_may_send_poses(computer: Computer, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tracker's stream goes round the bus's access list, so an open port beside a guarded bus is worth a line."""
    assert computer.outcome(camera.sender) is None
    monkeypatch.delenv("ZENOH_CONFIG", raising=False)
    computer.sections = {"vicon": {}}
    assert computer.outcome(camera.sender) is CheckOutcome.PASS
    monkeypatch.setenv("ZENOH_CONFIG", "/etc/tendond/bus/vicon.json5")
    assert computer.outcome(camera.sender) is CheckOutcome.WARN
    computer.sections = {"vicon": {"sender": "192.168.10.1"}}
    assert computer.outcome(camera.sender) is CheckOutcome.PASS
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    computer.sections = {"vicon": {"source": "datastream"}}
    assert computer.outcome(camera.sender) is CheckOutcome.FAIL


def test_the_doctor_tells_for_how_many_days_there_is_room_for_logs(
    computer: Computer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two days of a run made 20 GB, and there are 40 GB: of logs that nobody removes, that is soon over."""
    begun = datetime.now(UTC) - timedelta(days=2)
    folder = computer.folder / "log"
    folder.mkdir()
    with (folder / f"paper-{begun:%Y%m%dT%H%M%SZ}.mcap").open("wb") as file:
        file.truncate(20_000_000_000)  # a hole: it takes no room
    disk = shutil._ntuple_diskusage(200_000_000_000, 160_000_000_000, 40_000_000_000)
    monkeypatch.setattr("shutil.disk_usage", lambda folder: disk)
    result = files.log_space(computer.rig)
    assert result.outcome is CheckOutcome.WARN
    assert "at 10.00 GB a day the disk is full in 4.0 days" in result.finding
    computer.sections = {"log": {"keep_size": 50.0}}
    result = files.log_space(computer.rig)
    assert result.outcome is CheckOutcome.PASS
    assert "20.0 GB of logs of 50.0 GB that may be kept" in result.finding
    assert "at 10.00 GB a day the oldest are removed in 3.0 days" in result.finding
