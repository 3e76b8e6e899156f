"""Fixtures of the tests of the servo tools."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tests.rig.servos import calibration, emulated, hang_springs


@pytest.fixture
def servos(tmp_path: Path) -> Iterator[EmulatedBus]:
    with emulated(tmp_path, count=2) as bus:
        hang_springs(bus.servos, calibration((1, -1)))
        yield bus


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """Configuration of a robot with two tendons; fast, so that the tests are."""
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
reply_timeout = 0.1
slow_rate = 0.05
watchdog = 0.5
"""
    )
    return file
