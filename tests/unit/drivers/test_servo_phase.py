"""Phases of the servo driver, and the commands that lead to them: functions of commands and time alone."""

import pytest

from tendond.drivers.dynamixel.driver.commands import CommandStream
from tendond.drivers.dynamixel.driver.phase import DriverPhase, next_phase
from tendond.schemas.messages import TendonCommand
from tests.unit.drivers.servo_section import SECTION

TIMEOUT, HOLD, STOP = SECTION.command_timeout, SECTION.hold_time, SECTION.fault_hold
LONG = 10.0 * max(TIMEOUT, HOLD, STOP)
EDGE = 1e-6


@pytest.mark.parametrize(
    ("phase", "armed", "age", "elapsed", "after"),
    [
        (DriverPhase.ON, True, TIMEOUT, LONG, DriverPhase.ON),
        (DriverPhase.ON, True, TIMEOUT + EDGE, LONG, DriverPhase.HOLDING),
        (DriverPhase.ON, False, 0.0, 0.0, DriverPhase.RELEASING),
        (DriverPhase.ON, False, LONG, LONG, DriverPhase.RELEASING),
        (DriverPhase.HOLDING, True, TIMEOUT, LONG, DriverPhase.ON),
        (DriverPhase.HOLDING, True, LONG, HOLD, DriverPhase.HOLDING),
        (DriverPhase.HOLDING, True, LONG, HOLD + EDGE, DriverPhase.SILENT),
        (DriverPhase.STOPPED, True, 0.0, STOP, DriverPhase.STOPPED),
        (DriverPhase.STOPPED, True, 0.0, STOP + EDGE, DriverPhase.RELEASING),
    ],
)
def test_commands_and_time_lead_to_the_next_phase(
    phase: DriverPhase, armed: bool, age: float, elapsed: float, after: DriverPhase
) -> None:
    assert next_phase(SECTION, phase, armed=armed, age=age, elapsed=elapsed) is after


@pytest.mark.parametrize("phase", [DriverPhase.OFF, DriverPhase.SILENT, DriverPhase.RELEASING, DriverPhase.LOST])
@pytest.mark.parametrize("armed", [True, False])
@pytest.mark.parametrize("age", [0.0, LONG])
def test_no_command_and_no_time_alone_leads_out_of_the_other_phases(
    phase: DriverPhase, armed: bool, age: float
) -> None:
    assert next_phase(SECTION, phase, armed=armed, age=age, elapsed=LONG) is phase


def command(seq: int, *displacement: float, armed: bool = True) -> TendonCommand:
    zeros = (0.0,) * len(displacement)
    return TendonCommand(seq=seq, stamp_ns=0, pose_seq=None, displacement=displacement, tension=zeros, armed=armed)


def test_an_armed_command_counts_only_after_a_disarmed_one() -> None:
    stream = CommandStream(SECTION, tendons=2)
    assert stream.objection() == "the servos have received no command yet"
    stream.take(command(1, 0.0, 0.0), now=100.0)
    assert stream.armed
    assert stream.objection() == "the controller was armed before the servos were ready: stop it first"
    stream.take(command(2, 0.0, 0.0, armed=False), now=100.1)
    stream.take(command(3, 0.0, 0.0), now=100.2)
    assert stream.armed
    assert stream.objection() == ""
    stream.disarmed = False  # a fault
    assert stream.objection() == "the controller was armed before the servos were ready: stop it first"


def test_commands_of_another_size_and_older_armed_ones_are_not_used() -> None:
    stream = CommandStream(SECTION, tendons=2)
    assert stream.age(100.0) == float("inf")
    stream.take(command(5, 0.01, 0.0), now=100.0)
    for unused in (command(6, 0.0), command(5, 0.0, 0.0), command(4, 0.0, 0.0)):
        stream.take(unused, now=100.5)
    assert stream.newest == command(5, 0.01, 0.0)
    assert stream.age(100.5) == pytest.approx(0.5)
    assert stream.counts == {"wrong number of tendons": 1, "out of order": 2}


def test_a_disarmed_command_of_a_restarted_controller_is_used() -> None:
    stream = CommandStream(SECTION, tendons=2)
    stream.take(command(900, 0.01, 0.0), now=100.0)
    stream.take(command(1, 0.0, 0.0, armed=False), now=100.5)
    assert not stream.armed
    assert stream.age(101.0) == pytest.approx(0.5)


def test_armed_commands_beyond_the_range_are_counted_and_used() -> None:
    stream = CommandStream(SECTION, tendons=2)
    for seq, displacement in enumerate((SECTION.displacement_max + EDGE, SECTION.displacement_min - EDGE)):
        stream.take(command(seq, 0.0, displacement), now=100.0)
        assert stream.newest == command(seq, 0.0, displacement)
    stream.take(command(9, SECTION.displacement_max, SECTION.displacement_min), now=100.0)
    assert stream.counts == {"beyond the range": 2}
