"""Home, pretension and reboot by an operator, on emulated servos."""

import re
from functools import partial
from pathlib import Path

import pytest

from tendond.cli.servo.servo import reboot_servos
from tendond.cli.servo.tendons import home_servos, pretension_servos
from tendond.daemon.errors import DaemonError
from tendond.drivers.dynamixel.calibration import read_calibration, save_calibration
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.protocol import Error
from tendond.drivers.dynamixel.places import write_places
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.serial.register import Register
from tests.rig.servo.tools.operating import Operator, calibrated, displace, displaced, place
from tests.rig.servos import calibration

pytestmark = pytest.mark.rig


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


def test_home_does_not_pull_a_tendon_that_pulls_before_its_zero(
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


def test_a_servo_that_gets_an_error_meanwhile_is_switched_off(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    save_calibration(tmp_path / "calibration.json", calibration((1, -1)))
    servos.apply(lambda: setattr(servos.servos[0], "temperature", 70.0))
    with pytest.raises(ServoError, match="servo 1: 70 degrees"):
        home_servos(config, True, Operator())
    assert not any(servo.energised for servo in servos.servos)
    with ServoBus(str(tmp_path / "ttyUSB0"), 1_000_000, 0.1) as bus:
        assert bus.ping(1) == table.MODEL_NUMBER


def test_home_of_a_held_servo_that_counts_other_turns_releases_what_is_pulled_and_no_more(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    """The spool was turned by hand with the power on: three turns, then 20 mm of the driver's."""
    calibrated(tmp_path, 0.02, 0.0)
    displace(servos, 0.02, 0.0)

    def held() -> None:
        servos.servos[0]._turns = 3
        servos.servos[0]._switch_on()

    servos.apply(held)
    home_servos(config, True, Operator())
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)
    assert not any(servo.energised for servo in servos.servos)


def test_home_after_a_reboot_beyond_half_a_turn_releases_and_does_not_pull(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibrated(tmp_path, 0.0593, 0.0)
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0  # the gears hold
    displace(servos, 0.0593, 0.0)
    servos.apply(servos.servos[0].power_up)
    home_servos(config, True, Operator())
    assert "tendon 0 (servo 1): stands 59.3 mm from its zero" in capsys.readouterr().out
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)


def test_home_asks_where_a_tendon_of_uncertain_place_stands_and_uses_the_reply(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    calibrated(tmp_path)
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0
    displace(servos, 0.0593, 0.0)
    servos.apply(servos.servos[0].power_up)
    with pytest.raises(ServoError, match=r"servo 1: stands at 59\.\d or -3\d\.\d mm: .*--at"):
        home_servos(config, True, Operator())
    assert displaced(servos) == pytest.approx([0.0593, 0.0], abs=1e-3)
    with pytest.raises(DaemonError, match="--at 7=1: must be TENDON=MM with a tendon from 0 to 1"):
        home_servos(config, True, Operator(), ["7=1"])
    home_servos(config, True, Operator(), ["0=59"])
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)


@pytest.mark.parametrize("loss", [0.01, 0.2])
def test_tools_tolerate_lost_replies_as_the_driver_does(
    servos: EmulatedBus, config: Path, tmp_path: Path, loss: float
) -> None:
    config.write_text(config.read_text().replace("reply_timeout = 0.1", "reply_timeout = 0.02"))
    calibrated(tmp_path, 0.02, 0.01)
    servos.apply(lambda: setattr(servos, "loss", loss))
    for _ in range(3):
        displace(servos, 0.02, 0.01)
        calibrated(tmp_path, 0.02, 0.01)
        home_servos(config, True, Operator())
        assert displaced(servos) == pytest.approx([0.0, 0.0], abs=2e-3)
    place(servos, 1950.0, 2150.0)
    pretension_servos(config, False, True, Operator())
    assert not any(servo.energised for servo in servos.servos)


def test_a_tool_that_is_interrupted_releases_a_pulled_tendon_before_the_torque_goes(
    servos: EmulatedBus, config: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calibrated(tmp_path, 0.04, 0.0)
    displace(servos, 0.04, 0.0)
    servos.apply(servos.servos[0]._switch_on)
    calls = iter([False] * 20 + [True] * 1000)
    monkeypatch.setattr("tendond.cli.servo.tendons.stop_on_signals", lambda: lambda: next(calls))
    off_at: list[float] = []
    write = servos.servos[0]._write

    def watched(register: Register, value: int) -> Error:
        if register == table.TORQUE_ENABLE and value == 0 and servos.servos[0].energised:
            off_at.append(displaced(servos)[0])
        return write(register, value)

    servos.apply(lambda: setattr(servos.servos[0], "_write", watched))
    with pytest.raises(ServoError, match="servo 1: stopped"):
        home_servos(config, True, Operator())
    assert off_at == pytest.approx([0.0], abs=2e-3)


def test_home_drops_a_tendon_that_pulls_harder_while_it_is_released(
    servos: EmulatedBus, config: Path, tmp_path: Path
) -> None:
    """The calibration has the wrong sign: what it calls releasing pulls."""
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
        servos.apply(partial(servos.servos[1]._store, register, value))
        asked = len(servos.instructions)
        refused = f"servo 2: {re.escape(register.name)} is {value}, must be"
        with pytest.raises(ServoError, match=refused):
            home_servos(config, True, Operator())
        with pytest.raises(ServoError, match=refused):
            pretension_servos(config, False, True, Operator())
        assert not any(servo.energised for servo in servos.servos)
        torque = bytes([table.TORQUE_ENABLE.address, 0, 1])
        assert all(packet.parameters != torque for packet in servos.instructions[asked:])
        servos.apply(partial(servos.servos[1]._store, register, wanted))


def test_a_reboot_by_command_clears_a_hardware_error_and_keeps_the_place(
    servos: EmulatedBus, config: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    calibrated(tmp_path, 0.0593, 0.0)
    for servo in servos.servos:
        servo.torque = lambda ticks: 0.0
    displace(servos, 0.0593, 0.0)
    servos.apply(lambda: servos.servos[0].fail(5))
    reboot_servos(config, [1], False, Operator("yes"))
    assert "servo 1: rebooted; errors before: Overload Error (bit 5)" in capsys.readouterr().out
    home_servos(config, True, Operator())
    assert displaced(servos) == pytest.approx([0.0, 0.0], abs=1.5e-3)
