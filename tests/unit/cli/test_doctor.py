"""The doctor's checks of computer and files, on folders that say what a test wants."""

import shutil
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from tendond.cli.doctor import bus, camera, files, machine, servos
from tendond.cli.doctor.check import Check, CheckOutcome, Machine, Rig
from tendond.cli.doctor.listen import BusActivity
from tendond.cli.doctor.report import CHECKS, results_of
from tendond.drivers.dynamixel.calibration import save_calibration
from tendond.schemas.config.rig import check_config
from tendond.schemas.messages import TipPose
from tests.rig.servos import calibration

LIMITS = "Limit                     Soft Limit           Hard Limit           Units\n"


class Computer:
    """A folder each for /proc and /sys, and a rig on it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.synchronised = True
        self.sections: dict[str, Any] = {}
        self.config_file: Path | None = folder / "rig.toml"

    def write(self, path: str, text: str) -> None:
        file = self.folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    @property
    def rig(self) -> Rig:
        system = Machine(self.folder / "proc", self.folder / "sys", lambda: self.synchronised)
        return Rig(check_config(self.sections, "test"), self.config_file, self.folder / "log", machine=system)

    def outcome(self, check: Check) -> CheckOutcome | None:
        result = check(self.rig)
        assert result is None or bool(result.remedy) is (result.outcome is not CheckOutcome.PASS), result
        return None if result is None else result.outcome


@pytest.fixture
def computer(tmp_path: Path) -> Computer:
    return Computer(tmp_path)


def test_rights_of_this_user(computer: Computer) -> None:
    computer.write("proc/self/status", "CapEff:\t0000000000000000\n")
    for limit, locked, expected in (
        ("0", "8388608", CheckOutcome.WARN),
        ("49", "8388608", CheckOutcome.WARN),
        ("50", "unlimited", CheckOutcome.PASS),
        ("unlimited", "unlimited", CheckOutcome.PASS),
    ):
        lines = f"Max realtime priority     {limit}   {limit}\nMax locked memory         {locked}   {locked}   bytes\n"
        computer.write("proc/self/limits", LIMITS + lines)
        assert computer.outcome(machine.priority) is expected
        assert computer.outcome(machine.memory) is expected
    computer.write(
        "proc/self/limits", LIMITS + "Max realtime priority     0  0\nMax locked memory         0  0  bytes\n"
    )
    computer.write("proc/self/status", f"CapEff:\t{1 << 23 | 1 << 14:016x}\n")
    assert computer.outcome(machine.priority) is CheckOutcome.PASS
    assert computer.outcome(machine.memory) is CheckOutcome.PASS


def test_a_running_controller_is_judged_by_what_it_has(computer: Computer) -> None:
    """Whatever the user's own rights are; another rig's controller does not count."""
    computer.write("proc/self/limits", LIMITS + "Max realtime priority     99  99\n")
    for pid, config, policy, locked in ((70, "other.toml", 1, 400000), (71, "rig.toml", 0, 12)):
        words = ["/opt/tendond/bin/python", "-m", "tendond.cli", "run", "--config", config]
        computer.write(f"proc/{pid}/cmdline", "\0".join(words) + "\0")
        computer.write(f"proc/{pid}/status", f"VmLck:\t{locked} kB\nVmRSS:\t300000 kB\n")
        fields = ["0"] * 50
        fields[37], fields[38] = str(50 * policy), str(policy)
        computer.write(f"proc/{pid}/stat", f"{pid} (a name) with ) in it) {' '.join(fields)}")
        (computer.folder / f"proc/{pid}/cwd").symlink_to(computer.folder)
    assert machine.find_controller(computer.rig) == 71
    assert computer.outcome(machine.priority) is CheckOutcome.WARN
    assert computer.outcome(machine.memory) is CheckOutcome.WARN
    computer.config_file = computer.folder / "other.toml"
    assert machine.find_controller(computer.rig) == 70
    assert computer.outcome(machine.priority) is CheckOutcome.PASS
    assert computer.outcome(machine.memory) is CheckOutcome.PASS
    computer.config_file = None
    assert machine.find_controller(computer.rig) is None


@pytest.mark.parametrize(
    ("version", "cmdline", "expected"),
    [
        ("Linux version 6.1.0-rt (#1 SMP PREEMPT_RT Debian)", "", CheckOutcome.PASS),
        ("Linux version 6.1.0 (gcc) #1 SMP PREEMPT_DYNAMIC Debian", "quiet preempt=full", CheckOutcome.PASS),
        ("Linux version 6.1.0 (gcc) #1 SMP PREEMPT_DYNAMIC Debian", "quiet", CheckOutcome.WARN),
        ("Linux version 6.1.0 (gcc) #1 SMP PREEMPT Debian", "", CheckOutcome.PASS),
        ("Linux version 6.1.0 (gcc) #1 SMP Debian", "", CheckOutcome.WARN),
    ],
)
def test_kernels_and_how_they_preempt(computer: Computer, version: str, cmdline: str, expected: CheckOutcome) -> None:
    computer.write("proc/version", version)
    computer.write("proc/cmdline", cmdline)
    assert computer.outcome(machine.preemption) is expected


def test_processor_clock_and_governor(computer: Computer) -> None:
    assert computer.outcome(machine.idle_states) is CheckOutcome.PASS  # none at all
    assert computer.outcome(machine.governor) is CheckOutcome.PASS
    cpu = "sys/devices/system/cpu"
    computer.write(f"{cpu}/cpu0/cpuidle/state1/latency", "2")
    computer.write(f"{cpu}/cpu0/cpuidle/state2/latency", "890")
    assert computer.outcome(machine.idle_states) is CheckOutcome.WARN
    computer.write(f"{cpu}/cpu0/cpuidle/state2/disable", "1")
    assert computer.outcome(machine.idle_states) is CheckOutcome.PASS
    computer.write(f"{cpu}/cpu0/cpufreq/scaling_governor", "performance\n")
    assert computer.outcome(machine.governor) is CheckOutcome.PASS
    computer.write(f"{cpu}/cpu1/cpufreq/scaling_governor", "powersave\n")
    assert computer.outcome(machine.governor) is CheckOutcome.WARN
    computer.write(f"{cpu}/online", "0-1,3\n")
    assert computer.outcome(machine.processor) is None
    for number, expected in ((0, CheckOutcome.PASS), (2, CheckOutcome.FAIL), (3, CheckOutcome.PASS)):
        computer.sections = {"loop": {"cpu": number}}
        assert computer.outcome(machine.processor) is expected
    assert computer.outcome(machine.governor) is CheckOutcome.PASS  # of processor 3 alone, which has none
    source = "sys/devices/system/clocksource/clocksource0/current_clocksource"
    for name, expected in (("tsc", CheckOutcome.PASS), ("hpet", CheckOutcome.WARN)):
        computer.write(source, name)
        assert computer.outcome(machine.clock) is expected
    assert computer.outcome(machine.wall_clock) is CheckOutcome.PASS
    computer.synchronised = False
    assert computer.outcome(machine.wall_clock) is CheckOutcome.WARN


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


def test_the_adapters_timer(computer: Computer) -> None:
    adapter = computer.folder / "ttyUSB7"
    computer.sections = {"limits": {"displacement_rate": 0.08, "displacement_min": -0.08, "displacement_max": 0.08}}
    computer.sections["servo"] = {"port": str(adapter)}
    assert computer.outcome(servos.port) is CheckOutcome.FAIL
    assert computer.outcome(servos.latency) is None
    adapter.touch()
    assert computer.outcome(servos.port) is CheckOutcome.FAIL  # a file, no port
    assert computer.outcome(servos.latency) is CheckOutcome.PASS  # no timer
    for milliseconds, expected in (("1", CheckOutcome.PASS), ("2", CheckOutcome.WARN), ("16", CheckOutcome.FAIL)):
        computer.write("sys/bus/usb-serial/devices/ttyUSB7/latency_timer", f"{milliseconds}\n")
        assert computer.outcome(servos.latency) is expected


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
    from tendond.model.warm import warm_up

    warm_up()
    assert computer.outcome(files.kernels) is CheckOutcome.PASS
    absent: Callable[[], dict[str, str]] = dict
    from tendond.model.numerics import compile as compiling

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
    monkeypatch.setattr(camera, "is_installed", lambda: False)
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
