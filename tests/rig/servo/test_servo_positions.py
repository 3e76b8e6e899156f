"""Positions of emulated servos at a time that has passed, for a plant that is late."""

import time
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.emulator.bus import EmulatedBus
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial import table


def test_a_late_plant_gets_the_positions_of_its_own_time(tmp_path: Path) -> None:
    servo = EmulatedServo(1, 57600)
    servo.write(table.OPERATING_MODE.address, table.OPERATING_MODE.to_bytes(table.EXTENDED_POSITION))
    with EmulatedBus(tmp_path / "ttyUSB0", [servo]) as bus:

        def move() -> None:
            servo.write(table.TORQUE_ENABLE.address, table.TORQUE_ENABLE.to_bytes(1))
            servo.write(table.GOAL_POSITION.address, table.GOAL_POSITION.to_bytes(6000))

        time.sleep(0.03)
        began = time.monotonic()
        bus.apply(move)
        time.sleep(0.08)
        ended = time.monotonic()
        parts = [bus.positions(began + part * (ended - began))[0] for part in (-0.1, 0.3, 0.6, 0.9)]
        assert parts == sorted(parts)
        assert parts[0] == pytest.approx(2048, abs=1)
        assert parts[1] < parts[2] < parts[3] < 6000
        assert bus.positions(ended + 10.0)[0] >= parts[3]
    assert not bus.errors
