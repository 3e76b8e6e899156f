"""The servo driver's own safety: every reaction is caused for real, on emulated servos behind a pseudo-terminal."""

import itertools
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.emulator.protocol import Instruction
from tendond.drivers.dynamixel.process import ReadLossLog
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.serial.late import LateReplies
from tests.rig.bench import PULLED, DriverBench, section
from tests.rig.servos import SHORT_SECONDS, emulated

pytestmark = pytest.mark.rig


@pytest.mark.parametrize(
    ("cause", "fault"),
    [
        (lambda servo: servo.fail(5), "servo 3: Overload Error (bit 5)"),
        (lambda servo: servo.fail(4), "servo 3: Electrical Shock Error (bit 4)"),
        (lambda servo: setattr(servo, "temperature", 75.0), "servo 3: Overheating Error (bit 2)"),
        (lambda servo: setattr(servo, "temperature", 70.0), "servo 3: 70 degrees, servo.temperature_max is 68"),
        (lambda servo: setattr(servo, "voltage", 5.0), "servo 3: Input Voltage Error (bit 0)"),
        (lambda servo: setattr(servo, "voltage", 9.0), "servo 3: 9.0 V, allowed: 9.5 to 13 V"),
        (lambda servo: servo.power_up(), "servo 3: its torque is off: it has been rebooted or has lost power"),
        (lambda servo: servo._store(table.BUS_WATCHDOG, -1), "servo 3: its Bus Watchdog has stopped it"),
        (lambda servo: setattr(servo, "torque", lambda ticks: -1.2), "tendon 2 (servo 3): load 86%"),
    ],
)
def test_whatever_happens_to_one_servo_stops_all_tendons_together_and_is_named(
    bench: DriverBench, cause: Callable[[object], None], fault: str
) -> None:
    stops_all_tendons(bench, cause, fault)


def test_a_servo_that_falls_silent_stops_all_tendons_together_and_is_named(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section(reply_timeout=SHORT_SECONDS))
        stops_all_tendons(bench, lambda servo: setattr(servo, "silent", True), "servo 3: does not reply")
        bench.driver.session.bus.close()


def stops_all_tendons(bench: DriverBench, cause: Callable[[object], None], fault: str) -> None:
    """Cause it on the servo of tendon 2 while two tendons pull."""
    bench.pull()
    bench.servos.apply(lambda: cause(bench.servos.servos[2]))
    further = (0.025, 0.0, 0.02, 0.0)
    bench.until(lambda one: one.phase is DriverPhase.STOPPED, further)
    assert fault in bench.driver.fault
    stopped = bench.driver.session.goals
    assert max(stopped) < 0.025
    bench.driver.cycle(time.monotonic(), bench.command(further))
    assert all(after <= before for after, before in zip(bench.driver.session.goals, stopped, strict=True))
    bench.ends_slack_and_off(fault)
    assert all(packet.instruction != Instruction.REBOOT for packet in bench.servos.instructions)


def test_a_blocked_servo_is_detected_by_its_following_error(bench: DriverBench) -> None:
    bench.pull()
    bench.servos.apply(lambda: setattr(bench.servos.servos[0], "stuck", True))
    bench.until(lambda one: one.phase is DriverPhase.STOPPED, (0.05, 0.0, 0.0, 0.0))
    assert "tendon 0 (servo 1)" in bench.driver.fault
    assert "blocked" in bench.driver.fault


def test_a_servo_that_slips_out_of_its_range_is_a_fault(bench: DriverBench) -> None:
    bench.pull()
    bench.servos.apply(lambda: bench.servos.servos[0]._shaft.place(2048.0 + 0.1 / 0.015 / table.TICK))
    bench.until(lambda one: one.phase is DriverPhase.STOPPED, PULLED)
    assert "outside its range" in bench.driver.fault


def test_servos_that_their_watchdog_stopped_during_a_standstill_of_the_driver_are_released_all_the_same(
    bench: DriverBench,
) -> None:
    bench.pull()
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        time.sleep(0.01)
    bench.until(lambda one: one.phase is DriverPhase.RELEASING, PULLED)
    assert "Bus Watchdog has stopped it" in bench.driver.fault
    places = []
    while bench.driver.phase is DriverPhase.RELEASING:
        places.append(bench.driver.displacement[0])
        assert all(bench.torques)
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
        time.sleep(0.01)
    assert max(a - b for a, b in itertools.pairwise(places)) < 0.006
    assert places[-1] < 0.003


def test_one_wrong_crc_is_tolerated_and_a_burst_is_a_fault(bench: DriverBench) -> None:
    bench.pull()
    bench.servos.corrupt = 2
    for _ in range(10):
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
    assert bench.driver.phase is DriverPhase.ON
    bench.servos.corrupt = bench.section.silent_reads
    bench.until(lambda one: one.phase is DriverPhase.STOPPED, PULLED)
    assert "bad replies" in bench.driver.fault
    bench.ends_slack_and_off("bad replies")


def test_a_hardware_error_is_reset_once_its_servo_is_rebooted_by_command(bench: DriverBench) -> None:
    bench.pull()
    bench.servos.apply(lambda: bench.servos.servos[1].fail(5))
    bench.until(lambda one: one.phase is DriverPhase.OFF, PULLED)
    with pytest.raises(ServoError, match=r"servo 2: Overload Error \(bit 5\); fix its cause, then .*reset --reboot"):
        bench.driver.reset(time.monotonic())
    assert all(packet.instruction != Instruction.REBOOT for packet in bench.servos.instructions)
    assert bench.driver.reset(time.monotonic(), reboot=True) == "the fault is reset, servo 2 rebooted"
    assert [packet.id for packet in bench.servos.instructions if packet.instruction == Instruction.REBOOT] == [2]
    bench.pull()


def test_a_servo_that_lost_its_supply_for_a_moment_is_a_fault_and_its_turns_are_found_again(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section(reply_timeout=SHORT_SECONDS))
        bench.pull()
        servos.apply(lambda: setattr(servos.servos[0], "voltage", 3.0))
        bench.until(lambda one: bool(one.fault), PULLED)
        servos.apply(lambda: setattr(servos.servos[0], "voltage", 12.0))
        bench.until(lambda one: one.phase is DriverPhase.OFF, PULLED)
        assert bench.driver.reset(time.monotonic()) == "the fault is reset"
        bench.pull()
        bench.driver.session.bus.close()


def test_replies_that_come_late_are_not_taken_for_those_to_the_next_question(tmp_path: Path) -> None:
    """The adapter keeps every reply for 30 ms, and the driver waits for 16: each belongs to the question before."""
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section(reply_timeout=0.012, silent_reads=10))
        bench.until(lambda one: one.commands.disarmed, PULLED, armed=False)
        servos.apply(lambda: setattr(servos, "late", 0.03))
        before = bench.driver.displacement
        servos.apply(lambda: servos.servos[0]._shaft.place(2048.0 + 100.0))
        bench.until(lambda one: bool(one.fault), PULLED, armed=False)
        assert bench.driver.displacement == before
        assert "replies came late, by up to" in bench.driver.fault
        assert "latency timer" in bench.driver.fault
        assert bench.driver.session.bus.transport.late.count > 0
        bench.driver.session.bus.close()


def test_lost_and_late_reads_are_reported_at_a_bounded_rate() -> None:
    log, late = ReadLossLog(0.0), LateReplies()
    assert log.line(10.0, 0, late) == ""
    assert log.line(10.1, 21, late) == "21 reads without a reply in 10 s"
    assert log.line(15.0, 30, late) == ""
    late.count, late.by = 4, 0.017
    assert log.line(20.2, 30, late) == (
        "9 reads without a reply in 10 s, 4 replies late, by up to 17 ms: is the adapter's latency timer 1 ms?"
    )
    assert log.line(40.0, 30, late) == ""
    log.note(0.002)
    assert log.line(60.0, 30, late) == ""
    log.note(0.0165)
    assert log.line(80.2, 30, late) == (
        "0 reads without a reply in 60 s, replies take 16 ms more than their time on the wire: is the adapter's"
        " latency timer 1 ms?"
    )


def test_a_watchdog_that_tripped_leaves_no_profile_and_the_release_has_one_again(bench: DriverBench) -> None:
    bench.pull()
    wanted = [(one.value(table.PROFILE_VELOCITY), one.value(table.PROFILE_ACCELERATION)) for one in bench.servos.servos]
    bench.until(lambda one: one.phase is DriverPhase.SILENT)
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        time.sleep(0.01)
    assert all(one.value(table.PROFILE_VELOCITY) == 0 for one in bench.servos.servos)
    bench.driver.reset(time.monotonic())
    now = [(one.value(table.PROFILE_VELOCITY), one.value(table.PROFILE_ACCELERATION)) for one in bench.servos.servos]
    assert now == wanted
    assert min(velocity for velocity, _ in now) > 0
    bench.until(lambda one: one.phase is DriverPhase.OFF)


def test_an_unplugged_port_is_a_fault_the_servos_stop_and_a_reset_opens_it_and_releases(bench: DriverBench) -> None:
    bench.pull()
    bench.servos.unplug()
    bench.until(lambda one: one.phase is DriverPhase.LOST, PULLED)
    assert "the port has gone away" in bench.driver.fault
    with pytest.raises(ServoError, match="cannot be opened"):
        bench.driver.reset(time.monotonic())
    assert "may still hold" in bench.driver.final_state
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
        time.sleep(0.01)
    bench.servos.plug()
    assert bench.driver.phase is DriverPhase.LOST
    assert "releasing the tendons" in bench.driver.reset(time.monotonic())
    bench.until(lambda one: one.phase is DriverPhase.OFF)
    assert not any(bench.torques)
    assert max(bench.driver.displacement) < 0.002


def test_an_unexpected_error_still_ends_with_the_torque_off(
    bench: DriverBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.pull()

    def failing(*_: object) -> tuple[float, ...]:
        raise ZeroDivisionError("of all things")

    monkeypatch.setattr("tendond.drivers.dynamixel.driver.session.release_step", failing)
    with pytest.raises(ZeroDivisionError):
        bench.driver.close(time.monotonic, time.sleep)
    assert not any(bench.torques)


def test_a_driver_that_is_killed_leaves_servos_that_stop_and_the_next_one_does_not_touch_them(
    bench: DriverBench,
) -> None:
    bench.pull()
    bench.driver.session.bus.close()
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        time.sleep(0.01)
    bench.driver = bench.new_driver()
    for armed in (False, True):
        for _ in range(5):
            bench.driver.cycle(time.monotonic(), bench.command(PULLED, armed))
    assert "still hold their tendons" in bench.driver.report
    assert all(bench.torques)
    bench.driver.close(time.monotonic, time.sleep)
    assert "left as they are" in bench.driver.final_state
    assert all(bench.torques)
