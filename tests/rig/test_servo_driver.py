"""The servo driver's own safety: every reaction is caused for real, on emulated servos behind a pseudo-terminal."""

import itertools
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.bus import NoAnswerError, ServoBus, ServoError
from tendond.drivers.dynamixel.driver import Phase, ServoDriver
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.protocol import Instruction
from tendond.schemas.config_servo import ServoSection
from tendond.schemas.messages import TendonCommand
from tests.rig.servos import ANSWER_SECONDS, BAUDRATE, SHORT_SECONDS, calibration, emulated, hang_springs

pytestmark = pytest.mark.rig

PATIENCE_SECONDS = 20.0
SLACK = (0.0, 0.0, 0.0, 0.0)
PULLED = (0.015, 0.0, 0.01, 0.0)


def section(**changes: object) -> ServoSection:
    """Short times, so that the tests are short; generous where a busy machine could be late."""
    fields = {
        "answer_timeout": ANSWER_SECONDS,
        "fault_hold": 0.1,
        "release_rate": 0.2,
        "release_time": 1.5,
        "hold_time": 0.2,
        "command_timeout": 0.3,
        "watchdog": 1.0,
        **changes,
    }
    return ServoSection.model_validate(fields)


class Bench:
    """A driver on emulated servos with springs, cycled here."""

    def __init__(self, servos: EmulatedBus, port: Path, settings: ServoSection) -> None:
        self.servos = servos
        self.section = settings
        self.port = str(port)
        self.calibration = calibration()
        hang_springs(servos, self.calibration)
        self.seq = 0
        self.driver = self.new_driver()

    def new_driver(self) -> ServoDriver:
        return ServoDriver(
            self.section, self.calibration, lambda: ServoBus(self.port, BAUDRATE, self.section.answer_timeout)
        )

    def command(self, displacement: tuple[float, ...], armed: bool = True) -> TendonCommand:
        self.seq += 1
        zeros = (0.0,) * len(displacement)
        return TendonCommand(
            seq=self.seq, stamp_ns=0, pose_seq=None, displacement=displacement, tension=zeros, armed=armed
        )

    def until(
        self, wanted: Callable[[ServoDriver], bool], displacement: tuple[float, ...] | None = None, armed: bool = True
    ) -> None:
        """Cycle, with a command in each or none at all."""
        deadline = time.monotonic() + PATIENCE_SECONDS
        while not wanted(self.driver):
            assert time.monotonic() < deadline, (self.driver.phase, self.driver.report, self.driver.displacement)
            command = None if displacement is None else self.command(displacement, armed)
            self.driver.cycle(time.monotonic(), command)
            time.sleep(0.01)

    def pull(self) -> None:
        """Arm, and pull two tendons."""
        self.until(lambda one: one.phase is Phase.OFF and not one.objection and one._disarmed, SLACK, armed=False)
        self.until(lambda one: abs(one.displacement[0] - PULLED[0]) < 1e-4, PULLED)
        assert self.driver.phase is Phase.ON

    @property
    def torques(self) -> list[bool]:
        return [servo.energised for servo in self.servos.servos if not servo.silent]

    def ends_slack_and_off(self, fault: str) -> None:
        """The fault is latched; the tendons are let out, the torque is off, and armed commands change nothing."""
        self.until(lambda one: one.phase is Phase.OFF, PULLED)
        assert fault in self.driver.fault
        for _ in range(20):
            self.driver.cycle(time.monotonic(), self.command(PULLED))
        assert self.driver.phase is Phase.OFF
        assert not any(self.torques)


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    with emulated(tmp_path) as servos:
        one = Bench(servos, tmp_path / "ttyUSB0", section())
        yield one
        one.driver._bus.close()


def test_tendons_follow_the_command_at_the_rate_that_is_allowed(bench: Bench) -> None:
    bench.until(lambda one: one._disarmed, SLACK, armed=False)
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


def test_tendons_that_were_let_out_are_wound_up_again_while_the_others_are_let_out(bench: Bench) -> None:
    bench.until(lambda one: one._disarmed, SLACK, armed=False)
    bench.until(lambda one: one.displacement[1] < -0.0148, (0.015, -0.015, 0.0, 0.0))
    while bench.driver.phase is not Phase.OFF:
        bench.driver.cycle(time.monotonic(), bench.command(SLACK, armed=False))
        assert abs(bench.driver._goals[0] + bench.driver._goals[1]) < 1e-3
        time.sleep(0.01)
    assert bench.driver.displacement == pytest.approx(SLACK, abs=2e-3)


def test_a_tendon_that_was_let_out_but_pulls_is_not_wound_up_against_a_robot_that_stays_bent(bench: Bench) -> None:
    bench.until(lambda one: one._disarmed, SLACK, armed=False)
    bench.until(lambda one: one.displacement[1] < -0.0148, (0.015, -0.015, 0.0, 0.0))
    bent = -0.012

    def pull(ticks: float) -> float:
        return 30.0 * max(0.0, (2048 - ticks) * table.TICK * 0.015 - bent)

    bench.servos.tell(lambda: setattr(bench.servos.servos[1], "torque", pull))
    furthest = []
    while bench.driver.phase is not Phase.OFF:
        bench.driver.cycle(time.monotonic(), bench.command(SLACK, armed=False))
        furthest.append(bench.driver.displacement[1])
        time.sleep(0.01)
    assert max(furthest) < 0.25 * bent


def test_a_controller_that_is_armed_already_is_not_taken_up_in_mid_motion(bench: Bench) -> None:
    for _ in range(20):
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
    assert "armed before the servos were ready" in bench.driver.report
    assert not any(bench.torques)
    bench.pull()


def test_disarmed_while_wound_up_lets_out_first_and_then_switches_off(bench: Bench) -> None:
    bench.pull()
    slowest: list[float] = []
    while bench.driver.phase is not Phase.OFF:
        bench.driver.cycle(time.monotonic(), bench.command(PULLED, armed=False))
        slowest.append(bench.driver.displacement[0])
        time.sleep(0.01)
    assert max(a - b for a, b in itertools.pairwise(slowest)) < 0.008
    assert slowest[-1] < 0.002
    assert not any(bench.torques)
    assert bench.driver.fault == ""
    bench.pull()


def test_a_lost_command_stream_is_held_then_the_servos_own_watchdog_stops_them(bench: Bench) -> None:
    bench.pull()
    bench.until(lambda one: one.phase is Phase.HOLDING)
    assert bench.driver.report == ""
    bench.until(lambda one: one.phase is Phase.SILENT)
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
    assert bench.driver.phase is Phase.SILENT
    assert "letting the tendons out" in bench.driver.reset(time.monotonic())
    bench.until(lambda one: one.phase is Phase.OFF)
    assert not any(bench.torques)
    assert max(bench.driver.displacement) < 0.002
    bench.pull()


def test_a_short_gap_in_the_command_stream_is_bridged(bench: Bench) -> None:
    bench.pull()
    bench.until(lambda one: one.phase is Phase.HOLDING)
    bench.until(lambda one: one.phase is Phase.ON, PULLED)
    assert bench.driver.fault == ""


@pytest.mark.parametrize(
    ("cause", "fault"),
    [
        (lambda servo: servo.fail(5), "servo 3: Overload Error (bit 5)"),
        (lambda servo: servo.fail(4), "servo 3: Electrical Shock Error (bit 4)"),
        (lambda servo: setattr(servo, "temperature", 75.0), "servo 3: Overheating Error (bit 2)"),
        (lambda servo: setattr(servo, "temperature", 70.0), "servo 3: 70 degrees, servo.temperature_max is 68"),
        (lambda servo: setattr(servo, "voltage", 5.0), "servo 3: Input Voltage Error (bit 0)"),
        (lambda servo: setattr(servo, "voltage", 9.0), "servo 3: 9.0 V, allowed are 9.5 to 13 V"),
        (lambda servo: servo.power_up(), "servo 3: its torque is off: it has been rebooted or has lost power"),
        (lambda servo: servo._store(table.BUS_WATCHDOG, -1), "servo 3: its Bus Watchdog has stopped it"),
        (lambda servo: setattr(servo, "torque", lambda ticks: -1.2), "tendon 2 (servo 3): load 86%"),
    ],
)
def test_whatever_happens_to_one_servo_stops_all_tendons_together_and_is_named(
    bench: Bench, cause: Callable[[object], None], fault: str
) -> None:
    stops_all_tendons(bench, cause, fault)


def test_a_servo_that_falls_silent_stops_all_tendons_together_and_is_named(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = Bench(servos, tmp_path / "ttyUSB0", section(answer_timeout=SHORT_SECONDS))
        stops_all_tendons(bench, lambda servo: setattr(servo, "silent", True), "servo 3: does not answer")
        bench.driver._bus.close()


def stops_all_tendons(bench: Bench, cause: Callable[[object], None], fault: str) -> None:
    """Cause it on the servo of tendon 2 while two tendons pull."""
    bench.pull()
    bench.servos.tell(lambda: cause(bench.servos.servos[2]))
    further = (0.025, 0.0, 0.02, 0.0)
    bench.until(lambda one: one.phase is Phase.STOPPED, further)
    assert fault in bench.driver.fault
    stopped = bench.driver._goals
    assert max(stopped) < 0.025
    bench.driver.cycle(time.monotonic(), bench.command(further))
    assert all(after <= before for after, before in zip(bench.driver._goals, stopped, strict=True))
    bench.ends_slack_and_off(fault)
    assert all(packet.instruction != Instruction.REBOOT for packet in bench.servos.instructions)


def test_a_blocked_servo_is_noticed_by_what_it_is_behind(bench: Bench) -> None:
    bench.pull()
    bench.servos.tell(lambda: setattr(bench.servos.servos[0], "stuck", True))
    bench.until(lambda one: one.phase is Phase.STOPPED, (0.05, 0.0, 0.0, 0.0))
    assert "tendon 0 (servo 1)" in bench.driver.fault
    assert "blocked" in bench.driver.fault


def test_a_servo_that_slips_out_of_its_range_is_a_fault(bench: Bench) -> None:
    bench.pull()
    bench.servos.tell(lambda: bench.servos.servos[0]._shaft.place(2048.0 + 0.1 / 0.015 / table.TICK))
    bench.until(lambda one: one.phase is Phase.STOPPED, PULLED)
    assert "outside its range" in bench.driver.fault


def test_servos_that_their_watchdog_stopped_while_the_driver_could_not_run_are_let_out_all_the_same(
    bench: Bench,
) -> None:
    bench.pull()
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        time.sleep(0.01)
    bench.until(lambda one: one.phase is Phase.LETTING_OUT, PULLED)
    assert "Bus Watchdog has stopped it" in bench.driver.fault
    places = []
    while bench.driver.phase is Phase.LETTING_OUT:
        places.append(bench.driver.displacement[0])
        assert all(bench.torques)
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
        time.sleep(0.01)
    assert max(a - b for a, b in itertools.pairwise(places)) < 0.006
    assert places[-1] < 0.003


def test_one_wrong_crc_is_borne_and_a_burst_is_a_fault(bench: Bench) -> None:
    bench.pull()
    bench.servos.corrupt = 2
    for _ in range(10):
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
    assert bench.driver.phase is Phase.ON
    bench.servos.corrupt = bench.section.silent_reads
    bench.until(lambda one: one.phase is Phase.STOPPED, PULLED)
    assert "bad answers" in bench.driver.fault
    bench.ends_slack_and_off("bad answers")


def test_a_hardware_error_is_not_reset_before_it_is_gone_and_no_servo_is_rebooted(bench: Bench) -> None:
    bench.pull()
    bench.servos.tell(lambda: bench.servos.servos[1].fail(5))
    bench.until(lambda one: one.phase is Phase.OFF, PULLED)
    with pytest.raises(ServoError, match=r"servo 2: Overload Error \(bit 5\); mend it"):
        bench.driver.reset(time.monotonic())
    bench.servos.tell(bench.servos.servos[1].power_up)
    assert bench.driver.reset(time.monotonic()) == "the fault is reset"
    bench.pull()


def test_an_unplugged_port_is_a_fault_the_servos_stop_and_a_reset_opens_it_and_lets_out(bench: Bench) -> None:
    bench.pull()
    bench.servos.unplug()
    bench.until(lambda one: one.phase is Phase.LOST, PULLED)
    assert "the port has gone away" in bench.driver.fault
    with pytest.raises(ServoError, match="cannot be opened"):
        bench.driver.reset(time.monotonic())
    assert "may still hold" in bench.driver.farewell
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
        time.sleep(0.01)
    bench.servos.plug()
    assert bench.driver.phase is Phase.LOST
    assert "letting the tendons out" in bench.driver.reset(time.monotonic())
    bench.until(lambda one: one.phase is Phase.OFF)
    assert not any(bench.torques)
    assert max(bench.driver.displacement) < 0.002


def test_commands_that_do_not_fit_or_come_out_of_order_change_nothing(bench: Bench) -> None:
    bench.pull()
    old = bench.command(SLACK).model_copy(update={"seq": 0})
    for command in (old, bench.command((0.0,) * 3), bench.command((0.0,) * 5)):
        bench.driver.cycle(time.monotonic(), command)
    assert bench.driver.counts == {"out of order": 1, "wrong number of tendons": 2}
    assert bench.driver._goals == pytest.approx(PULLED)


def test_a_command_beyond_the_range_ends_at_its_edge(bench: Bench) -> None:
    bench.until(lambda one: one._disarmed, SLACK, armed=False)
    bench.until(lambda one: one.displacement[0] > 0.079, (0.5, -0.5, 0.0, 0.0))
    for _ in range(20):
        bench.driver.cycle(time.monotonic(), bench.command((1e300, -1e300, 0.0, 0.0)))
        time.sleep(0.01)
    assert bench.driver.phase is Phase.ON
    assert bench.driver._goals[:2] == (bench.section.displacement_max, bench.section.displacement_min)
    assert bench.driver.counts["beyond the range"] > 0


def test_a_late_cycle_makes_no_jump(bench: Bench) -> None:
    bench.pull()
    before = bench.driver._goals[0]
    bench.driver.cycle(time.monotonic() + 0.25, bench.command((0.08, 0.0, 0.0, 0.0)))
    assert bench.driver._goals[0] - before <= 2.0 * bench.section.period * bench.section.displacement_rate + 1e-12


def test_a_tendon_away_from_its_zero_is_not_switched_on(tmp_path: Path) -> None:
    with emulated(tmp_path, position=2048 + 800) as servos:
        one = Bench(servos, tmp_path / "ttyUSB0", section())
        for armed in (False, True):
            for _ in range(5):
                one.driver.cycle(time.monotonic(), one.command(SLACK, armed))
        assert "mm from its zero, servo.home_window is 10 mm" in one.driver.report
        assert "tendond servo home" in one.driver.report
        assert not any(one.torques)


def test_turns_that_servos_forget_at_power_up_are_found_again(tmp_path: Path) -> None:
    with emulated(tmp_path, position=2060) as servos, ServoBus(str(tmp_path / "ttyUSB0"), BAUDRATE, 0.1) as bus:
        driver = ServoDriver(section(), calibration(zero=2048 + 5 * 4096), lambda: bus)
        assert driver.displacement == pytest.approx([12 * table.TICK * 0.015 * s for s in (1, -1, 1, -1)])
        driver.cycle(time.monotonic(), None)
        assert driver.report == "the servos have heard no command yet"
        assert len(servos.servos) == 4


def test_at_exit_wound_tendons_are_let_out_and_the_torque_goes_off_in_order(bench: Bench) -> None:
    bench.pull()
    bench.driver.close(time.monotonic, time.sleep)
    assert not any(bench.torques)
    assert bench.driver.farewell == "the tendons are let out, the torque is off"
    assert max(bench.driver.displacement) < 0.002
    offs = [
        packet.id
        for packet in bench.servos.instructions
        if packet.instruction == Instruction.WRITE and packet.parameters == bytes([table.TORQUE_ENABLE.address, 0, 0])
    ]
    assert offs == [1, 2, 3, 4]


def test_an_error_that_nobody_foresaw_still_ends_with_the_torque_off(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench.pull()

    def failing(*_: object) -> tuple[float, ...]:
        raise ZeroDivisionError("of all things")

    monkeypatch.setattr("tendond.drivers.dynamixel.driver.let_out", failing)
    with pytest.raises(ZeroDivisionError):
        bench.driver.close(time.monotonic, time.sleep)
    assert not any(bench.torques)


def test_a_driver_that_is_killed_leaves_servos_that_stop_and_the_next_one_does_not_touch_them(bench: Bench) -> None:
    bench.pull()
    bench.driver._bus.close()
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        time.sleep(0.01)
    bench.driver = bench.new_driver()
    for armed in (False, True):
        for _ in range(5):
            bench.driver.cycle(time.monotonic(), bench.command(PULLED, armed))
    assert "still hold their tendons" in bench.driver.report
    assert all(bench.torques)
    bench.driver.close(time.monotonic, time.sleep)
    assert "left as they are" in bench.driver.farewell
    assert all(bench.torques)


def test_servos_that_are_missing_or_not_set_up_are_refused_with_the_remedy(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = Bench(servos, tmp_path / "ttyUSB0", section())
        bench.driver._bus.close()
        servos.servos[1].silent = True
        with pytest.raises(NoAnswerError, match=r"no answer from servo 2: .*tendond servo scan"):
            bench.new_driver()
        servos.servos[1].silent = False
        servos.servos[2].write(table.OPERATING_MODE.address, bytes([3]))
        with pytest.raises(ServoError, match="servo 3: Operating Mode is 3, must be 4: run 'tendond servo setup'"):
            bench.new_driver()
        servos.servos[0].write(table.STARTUP_CONFIGURATION.address, bytes([1]))
        with pytest.raises(ServoError, match="servo 1: Startup Configuration is 1, must be 0"):
            bench.new_driver()


def test_servos_that_do_not_know_fast_sync_read_are_named_and_work_without_it(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        servos.knows_fast = False
        with pytest.raises(ServoError, match=r"do not know Fast Sync Read.* servo.fast_read = false"):
            Bench(servos, tmp_path / "ttyUSB0", section())
        Bench(servos, tmp_path / "ttyUSB0", section(fast_read=False)).pull()
