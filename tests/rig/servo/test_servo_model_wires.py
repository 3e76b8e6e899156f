"""Servos of other models on a real pseudo-terminal: set up, pulled, stopped by their watchdog, released; scanned."""

import time
from pathlib import Path

import pytest

from tendond.cli.servo.servo import scan_servos, set_up_servo
from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoError
from tendond.drivers.dynamixel.serial.models import MODELS
from tests.rig.bench import DriverBench, section
from tests.rig.servos import emulated
from tests.unit.drivers.test_servo_models import KINDS

pytestmark = pytest.mark.rig

OTHERS = {name: kind for name, kind in KINDS.items() if name != "XL430"}


@pytest.mark.parametrize("kind", OTHERS)
def test_a_servo_of_any_kind_is_pulled_stopped_by_its_own_watchdog_and_released_by_a_reset(
    kind: str, tmp_path: Path
) -> None:
    settings = section(watchdog=0.3, **OTHERS[kind])
    with emulated(tmp_path, section=settings) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", settings, 20.0)
        bench.pull()
        bench.until(lambda one: one.phase is DriverPhase.SILENT)
        while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in servos.servos):
            time.sleep(0.01)
        assert all(bench.torques)
        assert "releasing the tendons" in bench.driver.reset(time.monotonic())
        bench.until(lambda one: one.phase is DriverPhase.OFF)
        assert not any(bench.torques)
        assert bench.driver.displacement[0] < 0.004
        assert not servos.errors
        bench.driver.session.bus.close()


@pytest.mark.parametrize("kind", OTHERS)
def test_scan_names_a_new_servo_of_any_kind_and_setup_prepares_it_for_the_driver(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    settings = OTHERS[kind]
    servo = EmulatedServo(1, 57600, model=MODELS[str(settings["model"])])
    keys = "\n".join(
        f'{name} = "{value}"' if name == "model" else f"{name} = {value}" for name, value in settings.items()
    )
    config = tmp_path / "rig.toml"
    config.write_text(f'[servo]\nport = "{tmp_path}/ttyUSB0"\nreply_timeout = 0.5\n{keys}\n', encoding="utf-8")
    with EmulatedBus(tmp_path / "ttyUSB0", [servo]) as servos:
        scan_servos(config, str(tmp_path / "ttyUSB0"), 3, patience=0.05)
        assert f"57600 bit/s, id 1: {settings['model']}\n" in capsys.readouterr().out
        set_up_servo(config, 1, 3, 57600, True, lambda question: "y")
        assert (servo.id, servo.baudrate) == (3, 1_000_000)
        assert servo.value(table.OPERATING_MODE) == (5 if kind == "XM430 in mode 5" else 4)
        assert not servos.errors
        config.write_text(f'[servo]\nport = "{tmp_path}/ttyUSB0"\nreply_timeout = 0.5\n', encoding="utf-8")
        with pytest.raises(ServoError, match=f"servo 3: is model {servo.model.number} .* not 1060"):
            set_up_servo(config, 3, None, None, True, lambda question: "y")
