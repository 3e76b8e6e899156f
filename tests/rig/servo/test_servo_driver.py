"""The servo driver in motion: rates, ranges, lost and late commands, start and end. Emulated servos."""

import itertools
import re
import time
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.driver.driver import ServoDriver
from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.emulator.protocol import Instruction
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import NoReplyError, ServoBus, ServoError
from tests.rig.bench import PATIENCE_SECONDS, PULLED, SLACK, DriverBench, section
from tests.rig.servos import BAUDRATE, SHORT_SECONDS, calibration, emulated

pytestmark = pytest.mark.rig


def test_tendons_follow_the_command_at_the_rate_that_is_allowed(bench: DriverBench) -> None:
    bench.until(lambda one: one.commands.disarmed, SLACK, armed=False)
    places, started = [], time.monotonic()
    while abs(bench.driver.displacement[0] - PULLED[0]) > 1e-4:
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
        places.append((time.monotonic(), bench.driver.displacement[0]))
        time.sleep(0.01)
        assert time.monotonic() - started < PATIENCE_SECONDS
    assert bench.driver.displacement == pytest.approx(PULLED, abs=5e-4)
    assert places[-1][0] - places[0][0] >= 0.9 * PULLED[0] / bench.section.displacement_rate
    assert max(b[1] - a[1] for a, b in itertools.pairwise(places)) < 0.01
    assert bench.driver.tension[0] == pytest.approx(600.0 * PULLED[0], rel=0.05)
    assert bench.driver.report == ""
    assert [servo.value(table.BUS_WATCHDOG) for servo in bench.servos.servos] == [50] * 4


def test_slack_tendons_are_taken_up_while_the_others_are_released(bench: DriverBench) -> None:
    bench.until(lambda one: one.commands.disarmed, SLACK, armed=False)
    bench.until(lambda one: one.displacement[1] < -0.0148, (0.015, -0.015, 0.0, 0.0))
    while bench.driver.phase is not DriverPhase.OFF:
        bench.driver.cycle(time.monotonic(), bench.command(SLACK, armed=False))
        assert abs(bench.driver.session.goals[0] + bench.driver.session.goals[1]) < 1e-3
        time.sleep(0.01)
    assert bench.driver.displacement == pytest.approx(SLACK, abs=2e-3)


def test_a_slack_tendon_that_pulls_is_not_taken_up_against_a_robot_that_stays_bent(bench: DriverBench) -> None:
    bench.until(lambda one: one.commands.disarmed, SLACK, armed=False)
    bench.until(lambda one: one.displacement[1] < -0.0148, (0.015, -0.015, 0.0, 0.0))
    bent = -0.012

    def pull(ticks: float) -> float:
        return 30.0 * max(0.0, (2048 - ticks) * table.TICK * 0.015 - bent)

    bench.servos.apply(lambda: setattr(bench.servos.servos[1], "torque", pull))
    furthest = []
    while bench.driver.phase is not DriverPhase.OFF:
        bench.driver.cycle(time.monotonic(), bench.command(SLACK, armed=False))
        furthest.append(bench.driver.displacement[1])
        time.sleep(0.01)
    assert max(furthest) < 0.25 * bent


def test_a_controller_that_is_armed_already_is_not_taken_up_in_mid_motion(bench: DriverBench) -> None:
    for _ in range(20):
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
    assert "armed before the servos were ready" in bench.driver.report
    assert not any(bench.torques)
    bench.pull()


def test_disarming_releases_the_tendons_before_it_switches_off(bench: DriverBench) -> None:
    bench.pull()
    slowest: list[float] = []
    while bench.driver.phase is not DriverPhase.OFF:
        bench.driver.cycle(time.monotonic(), bench.command(PULLED, armed=False))
        slowest.append(bench.driver.displacement[0])
        time.sleep(0.01)
    assert max(a - b for a, b in itertools.pairwise(slowest)) < 0.008
    assert slowest[-1] < 0.002
    assert not any(bench.torques)
    assert bench.driver.fault == ""
    bench.pull()


def test_a_lost_command_stream_is_held_then_the_servos_own_watchdog_stops_them(bench: DriverBench) -> None:
    bench.pull()
    bench.until(lambda one: one.phase is DriverPhase.HOLDING)
    assert bench.driver.report == ""
    bench.until(lambda one: one.phase is DriverPhase.SILENT)
    assert "no command for" in bench.driver.fault
    asked = len(bench.servos.instructions)
    started = time.monotonic()
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        bench.driver.cycle(time.monotonic(), None)
        time.sleep(0.01)
        assert time.monotonic() - started < PATIENCE_SECONDS
    assert len(bench.servos.instructions) == asked
    assert all(bench.torques)
    assert bench.driver.displacement == pytest.approx(PULLED, abs=5e-4)
    bench.driver.cycle(time.monotonic(), bench.command(PULLED))
    assert bench.driver.phase is DriverPhase.SILENT
    assert "releasing the tendons" in bench.driver.reset(time.monotonic())
    bench.until(lambda one: one.phase is DriverPhase.OFF)
    assert not any(bench.torques)
    assert max(bench.driver.displacement) < 0.002
    bench.pull()


def test_a_short_gap_in_the_command_stream_is_bridged(bench: DriverBench) -> None:
    bench.pull()
    bench.until(lambda one: one.phase is DriverPhase.HOLDING)
    bench.until(lambda one: one.phase is DriverPhase.ON, PULLED)
    assert bench.driver.fault == ""


def test_commands_that_do_not_fit_or_come_out_of_order_change_nothing(bench: DriverBench) -> None:
    bench.pull()
    old = bench.command(SLACK).model_copy(update={"seq": 0})
    for command in (old, bench.command((0.0,) * 3), bench.command((0.0,) * 5)):
        bench.driver.cycle(time.monotonic(), command)
    assert bench.driver.commands.counts == {"out of order": 1, "wrong number of tendons": 2}
    assert bench.driver.lost_reads == 0
    assert bench.driver.session.goals == pytest.approx(PULLED)


def test_a_command_beyond_the_range_ends_at_its_edge(bench: DriverBench) -> None:
    bench.until(lambda one: one.commands.disarmed, SLACK, armed=False)
    bench.until(lambda one: one.displacement[0] > 0.079, (0.5, -0.5, 0.0, 0.0))
    for _ in range(20):
        bench.driver.cycle(time.monotonic(), bench.command((1e300, -1e300, 0.0, 0.0)))
        time.sleep(0.01)
    assert bench.driver.phase is DriverPhase.ON
    assert bench.driver.session.goals[:2] == (bench.section.displacement_max, bench.section.displacement_min)
    assert bench.driver.commands.counts["beyond the range"] > 0


def test_a_late_cycle_makes_no_jump(bench: DriverBench) -> None:
    bench.pull()
    before = bench.driver.session.goals[0]
    bench.driver.cycle(time.monotonic() + 0.25, bench.command((0.08, 0.0, 0.0, 0.0)))
    assert (
        bench.driver.session.goals[0] - before <= 2.0 * bench.section.period * bench.section.displacement_rate + 1e-12
    )


def test_a_tendon_away_from_its_zero_is_not_switched_on(tmp_path: Path) -> None:
    with emulated(tmp_path, position=2048 + 800) as servos:
        one = DriverBench(servos, tmp_path / "ttyUSB0", section())
        one.driver.session.bus.close()
        one.driver = one.new_driver({1: 0.018, 2: -0.018, 3: 0.018, 4: -0.018})
        for armed in (False, True):
            for _ in range(5):
                one.driver.cycle(time.monotonic(), one.command(SLACK, armed))
        assert "mm from its zero, servo.home_window is 10 mm" in one.driver.report
        assert "tendond servo home" in one.driver.report
        assert not any(one.torques)
        one.driver.session.bus.close()
        unknown = one.driver = one.new_driver({})
        unknown.cycle(time.monotonic(), None)
        assert re.search(r"stands at 1\d\.\d or -7\d\.\d mm", unknown.report)
        assert "tendond servo home --at 0=MM" in unknown.report


def test_turns_that_servos_forget_at_power_up_are_found_again(tmp_path: Path) -> None:
    with emulated(tmp_path, position=2060) as servos, ServoBus(str(tmp_path / "ttyUSB0"), BAUDRATE, 0.1) as bus:
        driver = ServoDriver(section(), calibration(zero=2048 + 5 * 4096), lambda: bus)
        assert driver.displacement == pytest.approx([12 * table.TICK * 0.015 * s for s in (1, -1, 1, -1)])
        driver.cycle(time.monotonic(), None)
        assert driver.report == "the servos have received no command yet"
        assert len(servos.servos) == 4


def test_at_exit_tendons_are_released_and_the_torque_goes_off_in_order(bench: DriverBench) -> None:
    bench.pull()
    bench.driver.close(time.monotonic, time.sleep)
    assert not any(bench.torques)
    assert bench.driver.final_state == "the tendons are released, the torque is off"
    assert max(bench.driver.displacement) < 0.002
    offs = [
        packet.id
        for packet in bench.servos.instructions
        if packet.instruction == Instruction.WRITE and packet.parameters == bytes([table.TORQUE_ENABLE.address, 0, 0])
    ]
    assert offs == [1, 2, 3, 4]


def test_servos_that_are_missing_or_not_set_up_are_refused_with_the_remedy(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section(reply_timeout=SHORT_SECONDS))
        bench.driver.session.bus.close()
        servos.servos[1].silent = True
        with pytest.raises(NoReplyError, match=r"no reply from servo 2: .*tendond servo scan"):
            bench.new_driver()
        servos.servos[1].silent = False
        servos.servos[2].write(table.OPERATING_MODE.address, bytes([3]))
        with pytest.raises(
            ServoError, match=r"servo 3: Operating Mode is 3, must be 4 .*: run 'tendond servo setup' for 3"
        ):
            bench.new_driver()
        servos.servos[0].write(table.STARTUP_CONFIGURATION.address, bytes([1]))
        with pytest.raises(ServoError, match=r"servo 1: Startup Configuration is 1, must be 0 .*servo 3: Operating"):
            bench.new_driver()


def test_servos_that_do_not_know_fast_sync_read_are_named_and_work_without_it(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        servos.knows_fast = False
        with pytest.raises(ServoError, match=r"do not know Fast Sync Read.* servo.fast_read = false"):
            DriverBench(servos, tmp_path / "ttyUSB0", section(reply_timeout=SHORT_SECONDS))
        DriverBench(servos, tmp_path / "ttyUSB0", section(fast_read=False)).pull()
