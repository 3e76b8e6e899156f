"""Servos found and set up by an operator, on emulated ones."""

from pathlib import Path

import pytest

from tendond.cli.servo.rig import RefusedByOperatorError
from tendond.cli.servo.servo import scan_servos, set_up_servo
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.serial.port import open_failure
from tendond.drivers.dynamixel.tools.requirements import REQUIREMENTS
from tendond.drivers.dynamixel.tools.scan import ports
from tests.rig.servo.tools.operating import Operator

pytestmark = pytest.mark.rig


QUICK_SECONDS = 0.05
"""Emulated servos do not wait for their turn after a ping to all."""


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
        assert "id 32 replies as well, beyond --last-id" in capsys.readouterr().err
    with EmulatedBus(port, []), pytest.raises(DaemonError, match=r"no servo replies .*ids 0 to 252, 9600 to 4500000"):
        scan_servos(config, str(port), 252, QUICK_SECONDS)


def test_scan_names_two_servos_of_one_id(tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]) -> None:
    port = tmp_path / "ttyUSB0"
    twins = [EmulatedServo(1, 57600, position=2048), EmulatedServo(1, 57600, position=77)]
    with EmulatedBus(port, twins):
        scan_servos(config, str(port), 252, QUICK_SECONDS)
    assert "id 1: XL430-W250-T, whose replies collide: are there several with this id?" in capsys.readouterr().out
    twins[1]._store(table.FIRMWARE, 45)
    with EmulatedBus(port, twins), pytest.raises(DaemonError, match="garbled: plug in one servo at a time"):
        scan_servos(config, str(port), 252, QUICK_SECONDS)


def test_scan_finds_servos_behind_an_adapter_as_it_is_shipped_and_says_so(
    tmp_path: Path, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    config.write_text(config.read_text().replace("reply_timeout = 0.1", "reply_timeout = 0.004"))
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


def test_setup_makes_a_used_servo_what_it_must_be_despite_lost_replies(tmp_path: Path, config: Path) -> None:
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
