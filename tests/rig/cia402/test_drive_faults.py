"""Every fault of commands, drives and bus: all tendons stop together, are released, and lose their torque."""

import itertools
import math
import time
from collections.abc import Callable

import can
import pytest
from pydantic import ValidationError

from tendond.drivers.cia402.bus import BUS_OFF
from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.schemas.config.servo import ServoSection
from tests.rig.cia402.bench import DriveBench, drive_bench

pytestmark = pytest.mark.rig

ZERO = (0.0,) * 4
PULLED = (0.012, 0.0, 0.008, 0.0)
HASTY = ServoSection(release_time=0.3, fault_hold=0.1)
"""Where a drive is silent, and each of its reads costs the whole timeout."""


def phase(bench: DriveBench) -> DriverPhase:
    return bench.driver.phase


def pull(bench: DriveBench) -> None:
    """Pull two tendons against their springs."""
    bench.cycle(ZERO, armed=False, count=3)
    assert bench.driver.report == ""
    bench.cycle(PULLED, count=40)
    assert phase(bench) is DriverPhase.ON, bench.driver.report
    assert bench.driver.displacement == pytest.approx(PULLED, abs=1e-5)
    assert bench.powered == [True] * 4


def test_tendons_follow_within_the_rate_and_report_their_tension() -> None:
    with drive_bench() as bench:
        bench.cycle(ZERO, armed=False, count=3)
        bench.cycle(PULLED)  # enables
        before, furthest = bench.driver.displacement, 0.0
        for _ in range(40):
            bench.cycle(PULLED)
            furthest = max(furthest, *(abs(b - a) for a, b in zip(before, bench.driver.displacement, strict=True)))
            before = bench.driver.displacement
        assert 0.5 < furthest / (bench.servo.displacement_rate * bench.servo.period) < 1.01
        assert bench.driver.displacement == pytest.approx(PULLED, abs=1e-5)
        assert bench.driver.tension == pytest.approx((7.2, 0.0, 4.8, 0.0), abs=0.1)
        bench.cycle(PULLED, armed=False, count=60)
        assert phase(bench) is DriverPhase.OFF
        assert bench.driver.report == ""
        assert bench.powered == [False] * 4


def test_an_armed_command_counts_only_after_a_disarmed_one() -> None:
    with drive_bench() as bench:
        bench.cycle(PULLED, count=20)
        assert bench.powered == [False] * 4
        assert "the controller was armed before" in bench.driver.report
        assert [drive.position for drive in bench.each] == [1000.0] * 4


def test_a_stale_command_moves_nothing() -> None:
    with drive_bench() as bench:
        pull(bench)
        bench._seq = 0
        bench.cycle((0.03, 0.0, 0.03, 0.0), count=5)
        assert bench.driver.displacement == pytest.approx(PULLED, abs=1e-5)
        assert bench.driver.commands.counts["out of order"] == 5


def test_a_goal_beyond_the_range_ends_at_its_limit() -> None:
    with drive_bench() as bench:
        pull(bench)
        bench.each[0].load = lambda position: 0.0
        bench.cycle((0.5, 0.0, 0.008, 0.0), count=150)
        assert bench.driver.commands.counts["beyond the range"] == 150
        furthest = max(drive.value(0x607A) for drive in bench.each[:1])
        assert furthest == bench.driver.session.servos.spools[0].ticks(bench.servo.displacement_max)


def test_no_command_and_no_goal_can_be_other_than_finite() -> None:
    with drive_bench() as bench:
        pull(bench)
        targets = [drive.value(0x607A) for drive in bench.each]
        for wrong in (math.nan, math.inf):
            with pytest.raises(ValidationError):
                bench.command((wrong, 0.0, 0.0, 0.0), armed=True)
            with pytest.raises(ServoError, match="not finite"):
                bench.driver.session.servos.go((wrong, 0.0, 0.0, 0.0))
        bench.driver.session.servos.read()
        assert [drive.value(0x607A) for drive in bench.each] == targets


def fails(bench: DriveBench) -> None:
    bench.each[2].fail(0x4310)


def sticks(bench: DriveBench) -> None:
    """Without a following error of the drive's own, as of one that has no time out."""
    bench.each[2].put(0x6066, 0, 60000)
    bench.each[2].stuck = True


def reboots(bench: DriveBench) -> None:
    bench.each[2].reboot()


def falls_silent(bench: DriveBench) -> None:
    bench.each[2].silent = True


def loads(bench: DriveBench) -> None:
    bench.each[2].load = lambda position: 900.0


def falls_behind(bench: DriveBench) -> None:
    bench.each[2].behind = True


def stops(bench: DriveBench) -> None:
    """As a drive whose quick-stop input opens."""
    bench.each[2]._control(0x000B)


@pytest.mark.parametrize(
    ("cause", "fault"),
    [
        (fails, "servo 3: fault 0x4310, excess temperature of the drive"),
        (sticks, "from its goal: is it blocked?"),
        (reboots, "servo 3: does not reply"),
        (falls_silent, "servo 3: does not reply"),
        (loads, "(servo 3): load 90%, limit "),
        (falls_behind, "servo 3: following error"),
        (stops, "by itself"),
    ],
)
def test_whatever_happens_to_a_drive_stops_all_tendons_and_releases_them(
    cause: Callable[[DriveBench], None], fault: str
) -> None:
    with drive_bench(HASTY, enable_time=0.05) as bench:
        pull(bench)
        bench.drives.apply(lambda: cause(bench))
        wanted = (0.03, 0.0, 0.03, 0.0)
        for _ in range(100):
            bench.cycle(wanted)
            if phase(bench) is not DriverPhase.ON:
                break
        assert phase(bench) in (DriverPhase.STOPPED, DriverPhase.RELEASING)
        assert "servo 3" in bench.driver.fault
        assert fault in bench.driver.fault
        goals = []
        while phase(bench) in (DriverPhase.STOPPED, DriverPhase.RELEASING):
            goals.append(bench.driver.session.goals[0])
            bench.cycle(wanted)
        assert all(after <= before + 1e-9 for before, after in itertools.pairwise(goals))
        bench.cycle(wanted, count=5)
        assert phase(bench) is DriverPhase.OFF
        assert [bench.powered[i] for i in (0, 1, 3)] == [False] * 3
        assert bench.driver.session.servos.spools[0].displacement(round(bench.each[0].position)) < 1e-3


def test_the_drive_itself_faults_where_it_cannot_follow() -> None:
    """Its window is the driver's following error; here the driver does not look."""
    with drive_bench() as bench:
        pull(bench)
        bench.each[0].stuck = True
        group = bench.driver.session.servos
        group.go((0.03, 0.0, 0.008, 0.0))
        for _ in range(round(bench.servo.following_time / bench.servo.period) + 5):
            readings = [group.read()[0]]
        assert "fault 0x8611, following error" in readings[0].trouble
        assert not bench.each[0].powered


def test_without_commands_the_goals_are_held_then_the_drives_stop_themselves() -> None:
    with drive_bench() as bench:
        pull(bench)
        bench.cycle(None, count=15)
        assert phase(bench) is DriverPhase.HOLDING
        assert bench.driver.displacement == pytest.approx(PULLED, abs=1e-5)
        bench.cycle(None, count=120)
        assert phase(bench) is DriverPhase.SILENT
        bench.drives.wait(0.5 * bench.section.heartbeat)
        assert bench.powered == [True] * 4, "the heartbeat is younger than its time"
        bench.drives.wait(bench.section.heartbeat)
        assert bench.powered == [False] * 4
        bench.cycle(PULLED, count=10)
        assert phase(bench) is DriverPhase.SILENT, "a fault lasts until it is reset"
        assert bench.driver.reset(bench.now) == "the drives reply again, they have no torque"
        bench.cycle(ZERO, count=5)
        assert bench.powered == [False] * 4, "armed all along"
        bench.cycle(ZERO, armed=False, count=3)
        bench.cycle(PULLED, count=5)
        assert bench.powered == [True] * 4


def test_drives_that_hold_after_their_quick_stop_are_released_by_the_reset() -> None:
    with drive_bench(stop="hold") as bench:
        pull(bench)
        bench.cycle(None, count=140)
        assert phase(bench) is DriverPhase.SILENT
        bench.drives.wait(1.5 * bench.section.heartbeat)
        assert {drive.state for drive in bench.each} == {0x07}, "quick stop active"
        held = bench.driver.displacement
        bench.driver.reset(bench.now)
        assert phase(bench) is DriverPhase.RELEASING
        assert bench.driver.displacement == pytest.approx(held, abs=1e-5)
        bench.cycle(ZERO, count=80)
        assert phase(bench) is DriverPhase.OFF
        assert bench.powered == [False] * 4
        assert bench.driver.displacement == pytest.approx(ZERO, abs=1e-3)


def test_a_driver_that_was_too_late_finds_the_fault_and_does_not_go_on() -> None:
    with drive_bench() as bench:
        pull(bench)
        bench.drives.wait(1.5 * bench.section.heartbeat)
        bench.cycle(PULLED, count=3)
        assert phase(bench) in (DriverPhase.STOPPED, DriverPhase.RELEASING)
        assert "servo 1: fault" not in bench.driver.fault
        assert "by itself" in bench.driver.fault
        assert bench.powered == [False] * 4
        bench.cycle(PULLED, count=200)
        assert bench.powered == [False] * 4


def test_a_bus_off_controller_is_a_lost_port_and_the_drives_stop_themselves() -> None:
    with drive_bench() as bench:
        pull(bench)
        bus = can.Bus(interface="virtual", channel=bench.section.channel, ignore_config=True)
        bus.send(can.Message(arbitration_id=BUS_OFF, is_error_frame=True, is_extended_id=True, dlc=8, data=bytes(8)))
        bus.shutdown()
        deadline = time.monotonic() + 10.0
        while phase(bench) is DriverPhase.ON and time.monotonic() < deadline:
            bench.cycle(PULLED)
            time.sleep(0.01)
        assert phase(bench) is DriverPhase.LOST
        assert "bus-off" in bench.driver.fault
        bench.drives.wait(1.5 * bench.section.heartbeat)
        assert bench.powered == [False] * 4
        assert bench.driver.reset(bench.now) == "the port is open again"
        bench.cycle(PULLED, count=3)
        assert bench.powered == [False] * 4
        bench.cycle(ZERO, armed=False, count=3)
        bench.cycle(PULLED, count=5)
        assert bench.powered == [True] * 4


def released(bench: DriveBench) -> None:
    """Cycle until the fault is over."""
    for _ in range(600):
        bench.cycle(ZERO)
        if phase(bench) is DriverPhase.OFF:
            return
    raise AssertionError(bench.driver.phase)


def test_the_fault_of_a_drive_is_reset_only_on_request_and_only_once_its_cause_is_gone() -> None:
    with drive_bench() as bench:
        pull(bench)
        bench.drives.apply(lambda: bench.each[2].fail(0x2310))
        released(bench)
        with pytest.raises(ServoError, match=r"0x2310.*; fix its cause, then 'tendond servo reset --reboot'"):
            bench.driver.reset(bench.now)
        assert bench.driver.reset(bench.now, reboot=True) == "the fault is reset, servo 3 rebooted"
        bench.cycle(ZERO, armed=False, count=3)
        bench.cycle(PULLED, count=5)
        assert bench.powered == [True] * 4


def test_a_drive_that_lost_its_power_is_set_up_again_by_the_reset() -> None:
    with drive_bench(HASTY, enable_time=0.05) as bench:
        pull(bench)
        bench.drives.apply(bench.each[2].reboot)
        released(bench)
        assert bench.each[2].value(0x6007) == 1
        assert bench.driver.reset(bench.now) == "the fault is reset"
        assert bench.each[2].value(0x6007) == 3
        bench.cycle(ZERO, armed=False, count=3)
        bench.cycle(PULLED, count=5)
        assert bench.powered == [True] * 4


def test_closing_releases_the_tendons_and_switches_the_torque_off() -> None:
    with drive_bench() as bench:
        pull(bench)

        def now() -> float:
            bench.now += bench.servo.period
            return bench.now

        bench.driver.close(now, lambda seconds: None)
        assert bench.powered == [False] * 4
        assert bench.driver.displacement == pytest.approx(ZERO, abs=1e-3)
        assert bench.driver.final_state == "the tendons are released, the torque is off"
