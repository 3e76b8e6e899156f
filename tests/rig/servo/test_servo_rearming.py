"""A controller that was armed all along is not taken up again in mid-motion: first it has to be disarmed."""

import time
from collections.abc import Callable

import pytest

from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.serial import table
from tests.rig.bench import PULLED, SLACK, DriverBench

pytestmark = pytest.mark.rig


def heat(bench: DriverBench) -> None:
    servo = bench.servos.servos[1]
    bench.servos.apply(lambda: setattr(servo, "temperature", 70.0))
    bench.until(lambda one: one.phase is DriverPhase.OFF, PULLED)
    bench.servos.apply(lambda: setattr(servo, "temperature", 40.0))
    assert bench.driver.reset(time.monotonic()) == "the fault is reset"


def fall_silent(bench: DriverBench) -> None:
    bench.until(lambda one: one.phase is DriverPhase.SILENT)  # no command any more
    while any(servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED for servo in bench.servos.servos):
        time.sleep(0.01)
    assert "releasing the tendons" in bench.driver.reset(time.monotonic())
    bench.until(lambda one: one.phase is DriverPhase.OFF, PULLED)


@pytest.mark.parametrize("fault", [heat, fall_silent])
def test_after_a_fault_armed_commands_switch_nothing_on_before_a_disarmed_one_has_come(
    bench: DriverBench, fault: Callable[[DriverBench], None]
) -> None:
    bench.pull()
    fault(bench)
    for _ in range(30):
        bench.driver.cycle(time.monotonic(), bench.command(PULLED))
        assert bench.driver.phase is DriverPhase.OFF
        time.sleep(0.005)
    assert not any(bench.torques)
    assert "stop it first" in bench.driver.report
    bench.until(lambda one: not one.report, SLACK, armed=False)
    bench.pull()
    assert all(bench.torques)
