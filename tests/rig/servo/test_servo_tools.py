"""What an operator does with servos, on emulated ones: found, set up, calibrated, homed, tightened."""

import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tendond.cli.servo.rig import RefusedByOperatorError
from tendond.cli.servo.servo import reboot_servos, scan_servos, set_up_servo
from tendond.cli.servo.tendons import calibrate_servos, home_servos, pretension_servos
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel.calibration import CalibrationError, load_calibration, read_calibration, save_calibration
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.protocol import Error
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.places import Places, read_places, write_places
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.serial.port import open_failure
from tendond.drivers.dynamixel.tools.calibrate import MismatchError
from tendond.drivers.dynamixel.tools.requirements import REQUIREMENTS
from tendond.drivers.dynamixel.tools.scan import ports
from tests.rig.servos import calibration, emulated, hang_springs

pytestmark = pytest.mark.rig

QUICK_SECONDS = 0.05
"""Emulated servos do not wait for their turn after a ping to all."""


@pytest.fixture
def servos(tmp_path: Path) -> Iterator[EmulatedBus]:
    with emulated(tmp_path, count=2) as bus:
        hang_springs(bus, calibration((1, -1)))
        yield bus


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """Of a robot with two tendons; fast, so that the tests are."""
    file = tmp_path / "rig.toml"
    file.write_text(
        f"""
[rod]
tendon_positions = [[0.02, 0.0], [-0.02, 0.0]]
[simulator.rod]
tendon_positions = [[0.02, 0.0], [-0.02, 0.0]]
[limits]
displacement_rate = 0.08
displacement_min = -0.03
displacement_max = 0.08
[servo]
port = "{tmp_path}/ttyUSB0"
answer_timeout = 0.1
slow_rate = 0.05
watchdog = 0.5
"""
    )
    return file


class Operator:
    """Answers questions from a script, and remembers them."""

    def __init__(self, *answers: str | Callable[[], str]) -> None:
        self._answers = list(answers)
        self.asked: list[str] = []

    def __call__(self, question: str) -> str:
        self.asked.append(question)
        if not self._answers:
            raise RefusedByOperatorError("gone away")
        answer = self._answers.pop(0)
        return answer if isinstance(answer, str) else answer()


def test_scan_finds_servos_at_whatever_id_and_rate_and_changes_nothing(
    tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port = tmp_path / "ttyUSB0"
    several = [EmulatedServo(32, 57600), EmulatedServo(1, 1_000_000), EmulatedServo(200, 4_500_000)]
    with EmulatedBus(port, several):
        scan_servos(config, str(port), 252, QUICK_SECONDS)
        heard = capsys.readouterr()
        assert heard.out.splitlines() == [
            f"{port}: 57600 bit/s, id 32: XL430-W250-T",
            f"{port}: 1000000 bit/s, id 1: XL430-W250-T",
            f"{port}: 4500000 bit/s, id 200: XL430-W250-T",
        ]
        scan_servos(config, str(port), 20, QUICK_SECONDS)
        assert "id 32 answers as well, beyond --last-id" in capsys.readouterr().err
    with EmulatedBus(port, []), pytest.raises(DaemonError, match=r"no servo replies .*ids 0 to 252, 9600 to 4500000"):
        scan_servos(config, str(port), 252, QUICK_SECONDS)


def test_scan_names_two_servos_of_one_id(tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    port = tmp_path / "ttyUSB0"
    twins = [EmulatedServo(1, 57600, position=2048), EmulatedServo(1, 57600, position=77)]
    with EmulatedBus(port, twins):
        scan_servos(config, str(port), 252, QUICK_SECONDS)
    assert "id 1: XL430-W250-T, whose answers collide: are there several with this id?" in capsys.readouterr().out
    twins[1]._store(table.FIRMWARE, 45)
    with EmulatedBus(port, twins), pytest.raises(DaemonError, match="garbled: plug in one servo at a time"):
        scan_servos(config, str(port), 252, QUICK_SECONDS)


def test_scan_finds_servos_behind_an_adapter_as_it_is_shipped_and_says_so(
    tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config.write_text(config.read_text().replace("answer_timeout = 0.1", "answer_timeout = 0.004"))
    port = tmp_path / "ttyUSB0"
    with EmulatedBus(port, [EmulatedServo(1, 57600)]) as bus:
        bus.late = 0.0165
        scan_servos(config, str(port), 252, QUICK_SECONDS)
    assert "id 1: XL430-W250-T" in (said := capsys.readouterr().out)
    assert "latency timer" in said


def test_a_port_that_this_user_may_not_open_is_named_with_the_remedy() -> None:
    denied = open_failure("/dev/ttyUSB0", PermissionError(13, "Permission denied"))
    assert str(denied).endswith("cannot be opened: permission denied: adduser USER dialout, then log in again")


def test_each_adapter_is_scanned_once(tmp_path: Path) -> None:
    (tmp_path / "ttyUSB1").touch()
    (tmp_path / "serial" / "by-id").mkdir(parents=True)
    (tmp_path / "serial" / "by-id" / "usb-FTDI").symlink_to("../../ttyUSB1")
    assert ports(tmp_path) == [str(tmp_path / "ttyUSB1")]


def test_a_new_servo_is_set_up_after_confirmation(tmp_path: Path, config: Path) -> None:
    one = EmulatedServo(1, 57600)
    with EmulatedBus(tmp_path / "ttyUSB0", [one]):
        with pytest.raises(RefusedByOperatorError, match="nothing was done"):
            set_up_servo(config, 1, 4, 57600, False, Operator("no"))
        assert (one.id, one.baudrate) == (1, 57600)
        operator = Operator("yes")
        set_up_servo(config, 1, 4, 57600, False, operator)
        assert "set servo 1 to id 4" in operator.asked[0]
    assert (one.id, one.baudrate, one.value(table.OPERATING_MODE)) == (4, 1_000_000, table.EXTENDED_POSITION)
    assert {each.register: one.value(each.register) for each in REQUIREMENTS} == {
        each.register: each.wanted for each in REQUIREMENTS
    }


def test_setup_makes_a_used_servo_what_it_must_be_and_bears_lost_answers(tmp_path: Path, config: Path) -> None:
    one = EmulatedServo(7, 1_000_000)
    for register, value in ((table.SHUTDOWN, 0), (table.PWM_LIMIT, 200), (table.HOMING_OFFSET, 300)):
        one._store(register, value)
    one._store(table.STATUS_RETURN_LEVEL, 0)
    with EmulatedBus(tmp_path / "ttyUSB0", [one]) as bus:
        bus.loss = 0.2
        set_up_servo(config, 7, 2, None, True, Operator())
    assert (one.id, one.value(table.SHUTDOWN), one.value(table.PWM_LIMIT)) == (2, 52, 885)
    assert (one.value(table.HOMING_OFFSET), one.value(table.STATUS_RETURN_LEVEL)) == (0, 2)


def test_an_id_that_is_taken_or_a_servo_that_holds_is_not_touched(servos: EmulatedBus, config: Path) -> None:
    with pytest.raises(ServoError, match="servo 2: there is one already"):
        set_up_servo(config, 1, 2, None, True, Operator())
    servos.apply(lambda: servos.servos[0]._store(table.TORQUE_ENABLE, 1))
    with pytest.raises(ServoError, match="servo 1: its torque is on"):
        set_up_servo(config, 1, 5, None, True, Operator())
    assert [servo.id for servo in servos.servos] == [1, 2]


def place(servos: EmulatedBus, *ticks: float) -> None:
    def put() -> None:
        for servo, at in zip(servos.servos, ticks, strict=True):
            servo._shaft.place(at)

    servos.apply(put)


def mark(servos: EmulatedBus, index: int, radius: float) -> Callable[[], str]:
    """What a ruler shows of a mark on a tendon since it was last looked at, on a spool of that radius [m]: [mm]."""
    last = [servos.servos[index].position]

    def look() -> str:
        moved = servos.servos[index].position - last[0]
        last[0] += moved
        return f"{abs(moved) * table.TICK * radius * 1e3:.2f}"

    return look


def test_calibration_finds_id_sign_spool_and_zero_and_can_be_gone_on_with(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    """The springs begin to pull at 2048; servo 1 winds with larger positions, servo 2 with smaller ones."""
    place(servos, 1800.0, 2300.0)
    first = Operator("", "again", "0", "yes", "", mark(servos, 0, 0.015))
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, first)
    assert len(read_calibration(tmp_path / "calibration.json").tendons) == 1
    with pytest.raises(CalibrationError, match="unfinished, 1 of 2 tendons"):
        load_calibration(tmp_path / "calibration.json", "paper", (1, 2))
    second = Operator("", "1", "no", "", "nonsense", mark(servos, 1, 0.015))
    calibrate_servos(config, second)
    assert all("Tendon 0" not in question for question in second.asked)
    whole = load_calibration(tmp_path / "calibration.json", "paper", (1, 2))
    assert [tendon.sign for tendon in whole.tendons] == [1, -1]
    assert [tendon.spool_radius for tendon in whole.tendons] == pytest.approx([0.015, 0.015], rel=0.03)
    assert [tendon.zero for tendon in whole.tendons] == pytest.approx([2048, 2048], abs=450)
    assert whole.tendons[0].zero > 2048 > whole.tendons[1].zero
    assert not any(servo.energised for servo in servos.servos)
    assert read_places(tmp_path / "calibration-places.json", whole) == {1: 0.0, 2: 0.0}


def test_a_spool_of_another_size_than_configured_is_noticed_by_the_tendons_travel(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    place(servos, 1950.0, 2300.0)
    operator = Operator("", "0", "yes", "", mark(servos, 0, 0.03), "no", "", mark(servos, 0, 0.03), "yes")
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, operator)
    (found,) = read_calibration(tmp_path / "calibration.json").tendons
    assert found.spool_radius == pytest.approx(0.03, rel=0.03)
    assert "That makes a radius of 3" in operator.asked[5]
    assert "servo.spool_radius is 15 mm" in operator.asked[5]


def test_a_servo_that_moves_another_tendon_is_named_and_nothing_is_kept(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    place(servos, 1800.0, 2300.0)
    with pytest.raises(MismatchError, match=r"servo 1 moved tendon 1, not tendon 0: fix servo.ids"):
        calibrate_servos(config, Operator("", "1"))
    assert not (tmp_path / "calibration.json").exists()
    assert not any(servo.energised for servo in servos.servos)


def test_a_torn_calibration_is_set_aside_and_the_remedy_is_named(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "calibration.json").write_text('{"version": 1, "rig"')
    with pytest.raises(CalibrationError, match="run 'tendond servo calibrate', which sets it aside"):
        home_servos(config, True, Operator())
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, Operator())
    (kept,) = tmp_path.glob("calibration-*-unreadable.json")
    assert kept.read_text() == '{"version": 1, "rig"'
    assert f"set aside as {kept.name}" in capsys.readouterr().err


def test_a_servo_that_a_killed_calibration_left_on_is_taken_over(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    place(servos, 1800.0, 2300.0)
    servos.apply(servos.servos[0]._switch_on)
    servos.apply(lambda: servos.servos[0]._store(table.BUS_WATCHDOG, table.WATCHDOG_TRIPPED))
    with pytest.raises(RefusedByOperatorError):
        calibrate_servos(config, Operator("", "0", "yes", "", mark(servos, 0, 0.015)))
    assert "servo 1: was left on by an interrupted run, is off now" in capsys.readouterr().out
    assert len(read_calibration(tmp_path / "calibration.json").tendons) == 1
    servos.apply(servos.servos[1]._switch_on)
    servos.apply(lambda: setattr(servos.servos[1], "torque", lambda ticks: 0.5))
    with pytest.raises(ServoError, match=r"servo 2: holds a load of 3\d%: .*servo reboot 2"):
        calibrate_servos(config, Operator())
    assert servos.servos[1].energised


def test_a_calibration_of_another_rig_or_of_other_servos_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    save_calibration(path, calibration(rig="yours"))
    with pytest.raises(CalibrationError, match="is of rig 'yours', this is 'mine'"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    save_calibration(path, calibration((1, 1, 1, 1, 1), rig="mine"))
    with pytest.raises(CalibrationError, match=r"is for servos \[1, 2, 3, 4, 5\]"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    path.write_text('{"version": 1, "rig"')
    with pytest.raises(CalibrationError, match="is not a calibration"):
        load_calibration(path, "mine", (1, 2, 3, 4))
    path.unlink()
    with pytest.raises(CalibrationError, match="tendond servo calibrate"):
        load_calibration(path, "mine", (1, 2, 3, 4))


def test_a_calibration_is_whole_or_not_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "c.json"
    save_calibration(path, calibration(rig="first"))

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(CalibrationError, match="cannot be written: No space left"):
        save_calibration(path, calibration(rig="second"))
    assert read_calibration(path).rig == "first"
    assert [file.name for file in tmp_path.iterdir()] == ["c.json"]


def calibrated(folder: Path, *last: float, zero: int = 2048) -> None:
    """A calibration of both tendons, and where they were last known to be [m]."""
    made = calibration((1, -1), zero=zero)
    save_calibration(folder / "calibration.json", made)
    if last:
        write_places(folder / "calibration-places.json", made, {index + 1: place for index, place in enumerate(last)})


def test_home_brings_every_tendon_to_its_zero_and_switches_off(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibrated(tmp_path, -0.0126, -0.0127)
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0
    place(servos, 1500.0, 2600.0)
    home_servos(config, False, Operator("yes"))
    assert [servo.position for servo in servos.servos] == pytest.approx([2048, 2048], abs=60)
    assert not any(servo.energised for servo in servos.servos)
    assert "stands -12.6 mm" in capsys.readouterr().out


def test_home_does_not_wind_up_a_tendon_that_pulls_before_its_zero(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    calibrated(tmp_path, -0.0334, 0.0334, zero=3500)
    with pytest.raises(ServoError, match=r"servo 1: load 1\d% at -\d.*stopped"):
        home_servos(config, True, Operator())
    assert not any(servo.energised for servo in servos.servos)


def test_pretension_stops_at_the_load_and_stores_the_zero_with_the_old_one_kept(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1), zero=2000))
    place(servos, 1900.0, 2200.0)
    pretension_servos(config, True, True, Operator())
    zeros = [tendon.zero for tendon in read_calibration(tmp_path / "calibration.json").tendons]
    pull = 0.06 * 1.4 / 0.015 / 600.0 / 0.015 / table.TICK  # ticks at which the spring has the wanted load
    assert zeros == pytest.approx([2048 + pull, 2048 - pull], abs=60)
    (kept,) = tmp_path.glob("calibration-2026-01-01T000000Z.json")
    assert [tendon.zero for tendon in read_calibration(kept).tendons] == [2000, 2000]
    assert not any(servo.energised for servo in servos.servos)


def test_pretension_gives_up_where_no_load_comes(servos: EmulatedBus, config: Path, tmp_path: Path) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1)))
    servos.apply(lambda: setattr(servos.servos[0], "torque", lambda ticks: 0.0))
    with pytest.raises(ServoError, match="servo 1: no load within 30 mm"):
        pretension_servos(config, False, True, Operator())
    assert not any(servo.energised for servo in servos.servos)


def test_a_servo_that_gets_an_error_on_the_way_is_switched_off(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1)))
    servos.apply(lambda: setattr(servos.servos[0], "temperature", 70.0))
    with pytest.raises(ServoError, match="servo 1: 70 degrees"):
        home_servos(config, True, Operator())
    assert not any(servo.energised for servo in servos.servos)
    with ServoBus(str(tmp_path / "ttyUSB0"), 1_000_000, 0.1) as bus:
        assert bus.ping(1) == table.MODEL_NUMBER


def wind(servos: EmulatedBus, *displacements: float) -> None:
    """Turn the shafts to where the tendons are displaced so much [m], by the calibration of `calibrated`."""
    place(servos, *(2048.0 + sign * one / 0.015 / table.TICK for sign, one in zip((1, -1), displacements, strict=True)))


def displaced(servos: EmulatedBus) -> list[float]:
    """Displacement of both tendons by their shafts [m]."""
    return [
        sign * (servo.position - 2048) * table.TICK * 0.015 for sign, servo in zip((1, -1), servos.servos, strict=True)
    ]


def test_home_of_a_held_servo_that_counts_other_turns_lets_out_what_is_wound_and_no_more(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    """As a spool that was wound by hand with the power on: three turns, then 20 mm of the driver's."""
    calibrated(tmp_path, 0.02, 0.0)
    wind(servos, 0.02, 0.0)

    def held() -> None:
        servos.servos[0]._turns = 3
        servos.servos[0]._switch_on()

    servos.apply(held)
    home_servos(config, True, Operator())
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)
    assert not any(servo.energised for servo in servos.servos)


def test_home_after_a_reboot_beyond_half_a_turn_lets_out_and_does_not_wind_up(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibrated(tmp_path, 0.0593, 0.0)
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0  # the gears hold
    wind(servos, 0.0593, 0.0)
    servos.apply(servos.servos[0].power_up)
    home_servos(config, True, Operator())
    assert "tendon 0 (servo 1): stands 59.3 mm from its zero" in capsys.readouterr().out
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)


def test_home_asks_where_a_tendon_stands_that_nobody_knows_and_believes_the_operator(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    calibrated(tmp_path)
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0
    wind(servos, 0.0593, 0.0)
    servos.apply(servos.servos[0].power_up)
    with pytest.raises(ServoError, match=r"servo 1: stands at 59\.\d or -3\d\.\d mm: .*--at"):
        home_servos(config, True, Operator())
    assert displaced(servos) == pytest.approx([0.0593, 0.0], abs=1e-3)
    with pytest.raises(DaemonError, match="--at 7=1: must be TENDON=MM with a tendon from 0 to 1"):
        home_servos(config, True, Operator(), ["7=1"])
    home_servos(config, True, Operator(), ["0=59"])
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)


@pytest.mark.parametrize("loss", [0.01, 0.2])
def test_tools_bear_lost_answers_as_the_driver_does(
    servos: EmulatedBus, config: Path, tmp_path: Path, loss: float
) -> None:
    config.write_text(config.read_text().replace("answer_timeout = 0.1", "answer_timeout = 0.02"))
    calibrated(tmp_path, 0.02, 0.01)
    servos.apply(lambda: setattr(servos, "loss", loss))
    for _ in range(3):
        wind(servos, 0.02, 0.01)
        calibrated(tmp_path, 0.02, 0.01)
        home_servos(config, True, Operator())
        assert displaced(servos) == pytest.approx([0.0, 0.0], abs=2e-3)
    place(servos, 1950.0, 2150.0)
    pretension_servos(config, False, True, Operator())
    assert not any(servo.energised for servo in servos.servos)


def test_a_tool_that_is_interrupted_lets_a_wound_tendon_out_before_the_torque_goes(
    servos: EmulatedBus, config: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calibrated(tmp_path, 0.04, 0.0)
    wind(servos, 0.04, 0.0)
    servos.apply(servos.servos[0]._switch_on)
    calls = iter([False] * 20 + [True] * 1000)
    monkeypatch.setattr("tendond.cli.servo.tendons.stop_on_signals", lambda: lambda: next(calls))
    off_at: list[float] = []
    write = servos.servos[0]._write

    def watched(register: table.Register, value: int) -> Error:
        if register is table.TORQUE_ENABLE and value == 0 and servos.servos[0].energised:
            off_at.append(displaced(servos)[0])
        return write(register, value)

    servos.apply(lambda: setattr(servos.servos[0], "_write", watched))
    with pytest.raises(ServoError, match="servo 1: stopped"):
        home_servos(config, True, Operator())
    assert off_at == pytest.approx([0.0], abs=2e-3)


def test_home_drops_a_tendon_that_pulls_harder_while_it_is_let_out(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    """The calibration has the wrong sign: what it calls letting out winds up."""
    wrong = calibration((-1, -1))
    save_calibration(tmp_path / "calibration.json", wrong)
    write_places(tmp_path / "calibration-places.json", wrong, {1: 0.03, 2: 0.0})
    place(servos, 2048.0 - 0.03 / 0.015 / table.TICK, 2048.0)
    pull: list[float] = []

    def torque(ticks: float) -> float:
        stretched = max(0.0, (ticks - 2048.0) * table.TICK * 0.015 + 0.02)
        pull.append(5000.0 * stretched)
        return -5000.0 * stretched * 0.015

    servos.apply(lambda: setattr(servos.servos[0], "torque", torque))
    with pytest.raises(ServoError, match=r"servo 1: its load rises from 0% to \d+% while it is released: is its sign"):
        home_servos(config, True, Operator())
    assert max(pull) < 25.0
    assert not any(servo.energised for servo in servos.servos)


def test_tools_refuse_a_servo_that_is_not_what_it_must_be_before_its_torque_is_on(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    calibrated(tmp_path, 0.0, 0.0)
    changes = ((table.HOMING_OFFSET, 300), (table.SHUTDOWN, 0), (table.SECONDARY_ID, 2), (table.DRIVE_MODE, 1))
    for register, value in changes:
        wanted = servos.servos[1].value(register)
        servos.apply(lambda register=register, value=value: servos.servos[1]._store(register, value))  # type: ignore[misc]
        asked = len(servos.instructions)
        refused = f"servo 2: {re.escape(register.name)} is {value}, must be"
        with pytest.raises(ServoError, match=refused):
            home_servos(config, True, Operator())
        with pytest.raises(ServoError, match=refused):
            pretension_servos(config, False, True, Operator())
        assert not any(servo.energised for servo in servos.servos)
        torque = bytes([table.TORQUE_ENABLE.address, 0, 1])
        assert all(packet.parameters != torque for packet in servos.instructions[asked:])
        servos.apply(lambda register=register, value=wanted: servos.servos[1]._store(register, value))  # type: ignore[misc]


def test_a_reboot_by_command_clears_a_hardware_error_and_the_place_is_still_known(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibrated(tmp_path, 0.0593, 0.0)
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0
    wind(servos, 0.0593, 0.0)
    servos.apply(lambda: servos.servos[0].fail(5))
    reboot_servos(config, [1], False, Operator("yes"))
    assert "servo 1: rebooted; errors before: Overload Error (bit 5)" in capsys.readouterr().out
    home_servos(config, True, Operator())
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)


def test_places_of_another_calibration_are_not_believed(tmp_path: Path) -> None:
    made = calibration((1, -1))
    path = tmp_path / "places.json"
    write_places(path, made, {1: 0.01, 2: -0.02})
    assert read_places(path, made) == {1: 0.01, 2: -0.02}
    assert read_places(path, made.model_copy(update={"date": "2026-02-02T00:00:00+00:00"})) == {}
    path.write_text(path.read_text()[:20])
    assert read_places(path, made) == {}
    assert Places(rig="a", calibration="b").displacement == {}


class FakeCamera:
    """Bends as the servos' shafts make the rod bend, on spools of 15 mm; or as if the tendons were elsewhere.

    Args:
        servos: whose shafts are looked at.
        positions: of the tendons in the cross-section [m].
    """

    def __init__(self, servos: EmulatedBus, positions: tuple[tuple[float, float], ...]) -> None:
        self._servos = servos
        self._positions = positions

    def __enter__(self) -> "FakeCamera":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def bend(self, meanwhile: Callable[[], object] = lambda: None) -> tuple[float, float]:
        for _ in range(60):  # as long as a real one looks: the servo must not stop meanwhile
            meanwhile()
            time.sleep(0.005)
        bend = [0.0, 0.0]
        for (x, y), wound in zip(self._positions, displaced(self._servos), strict=True):
            far = x * x + y * y
            bend[0] += max(0.0, wound) * x / far
            bend[1] += max(0.0, wound) * y / far
        return bend[0], bend[1]


@pytest.mark.parametrize(
    ("positions", "complaint"),
    [
        (((0.02, 0.0), (-0.02, 0.0)), ""),
        (((-0.02, 0.0), (0.02, 0.0)), "the tip bent towards tendon 1: is the servo's id, or its sign, correct?"),
        (((0.045, 0.0), (-0.045, 0.0)), "is servo.spool_radius correct"),
    ],
)
def test_a_camera_confirms_each_tendon_or_says_what_does_not_fit(
    servos: EmulatedBus,
    config: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    positions: tuple[tuple[float, float], ...],
    complaint: str,
) -> None:
    place(servos, 2000.0, 2100.0)
    camera = FakeCamera(servos, positions)
    monkeypatch.setattr("tendond.drivers.dynamixel.tools.calibrate.Camera", lambda _: camera)
    operator = Operator("", "0", "yes", "", "1", "no")  # nobody is asked for a ruler
    if complaint:
        with pytest.raises(MismatchError, match=re.escape(complaint)):
            calibrate_servos(config, operator)
    else:
        calibrate_servos(config, operator)
        said = capsys.readouterr().out
        assert said.count("the camera measured") == 2
        assert said.count("id, sign, radius fit") == 2
    assert not any(servo.energised for servo in servos.servos)
