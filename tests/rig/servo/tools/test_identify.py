"""Identification of a servo by a step test, on emulated servos: what the emulator has is found, and refusals."""

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import pytest

from tendond.cli.servo import identify as identify_module
from tendond.cli.servo.identify import identify_servo
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.motor import SHAFT_LAG
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import Mode
from tendond.schemas.motors import XL430_W250
from tests.rig.servo.tools.operating import Operator, calibrated, displace, displaced

pytestmark = pytest.mark.rig

RADIUS = 0.015


@pytest.fixture
def slack(servos: EmulatedBus, tmp_path: Path) -> EmulatedBus:
    """Servos of two slack tendons."""
    calibrated(tmp_path, -0.002, -0.002)
    displace(servos, -0.002, -0.002)
    return servos


def test_a_servos_dynamics_are_found_and_printed_as_keys_and_it_is_off(
    slack: EmulatedBus, config: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fit = identify_servo(config, 0, 6e-3, False, Operator("yes"))
    section = ServoSection()
    assert fit.servo.rate == pytest.approx(section.profile_velocity * RADIUS, rel=0.1)
    assert fit.servo.acceleration == pytest.approx(section.profile_acceleration * RADIUS, rel=0.4)
    assert fit.servo.lag == pytest.approx(SHAFT_LAG, abs=0.01)
    assert not any(servo.energised for servo in slack.servos)
    assert displaced(slack) == pytest.approx([-0.002, -0.002], abs=1e-4)
    printed = capsys.readouterr().out
    keys = dict(line.split("#")[0].split(" = ") for line in printed.splitlines() if " = " in line)
    assert 0.0 < float(keys["command_delay"]) < 0.1
    assert float(keys["resolution"]) == pytest.approx(table.TICK * RADIUS, rel=1e-2)


def test_a_tendon_that_pulls_or_is_held_or_does_not_exist_is_not_moved(slack: EmulatedBus, config: Path) -> None:
    with pytest.raises(ServoError, match="there is no tendon 2: they are 0 to 1"):
        identify_servo(config, 2, 6e-3, True, Operator())
    with pytest.raises(ServoError, match=r"a travel of 20 mm is beyond servo\.following_error"):
        identify_servo(config, 0, 20e-3, True, Operator())
    second = slack.servos[1]
    second.grip = 1.0  # holds its load without torque
    slack.apply(lambda: setattr(second, "torque", lambda ticks: 0.1 * XL430_W250.stall_torque))
    with pytest.raises(ServoError, match=r"servo 2: its tendon pulls \(load 10%\): slacken it"):
        identify_servo(config, 1, 6e-3, True, Operator())
    second.write(table.TORQUE_ENABLE.address, b"\x01")
    with pytest.raises(ServoError, match="servo 2: holds its tendon"):
        identify_servo(config, 1, 6e-3, True, Operator())
    assert displaced(slack) == pytest.approx([-0.002, -0.002], abs=1e-4)


@pytest.mark.parametrize("mode", [Mode.PRETENSION, Mode.TRACKING, Mode.RELEASING, Mode.FAULT])
def test_an_armed_rig_is_refused(slack: EmulatedBus, config: Path, monkeypatch: pytest.MonkeyPatch, mode: Mode) -> None:
    """Refuse it by what the controller replies; that is scripted."""
    monkeypatch.setattr(identify_module, "open_client", lambda *_: nullcontext())
    monkeypatch.setattr(identify_module, "ask", lambda *_: None)
    monkeypatch.setattr(identify_module, "status_in", lambda _: SimpleNamespace(mode=mode))
    with pytest.raises(ServoError, match=f"is in mode {mode.value}: stop it first"):
        identify_servo(config, 0, 6e-3, True, Operator())
    assert displaced(slack) == pytest.approx([-0.002, -0.002], abs=1e-4)
