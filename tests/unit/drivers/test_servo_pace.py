"""Pace of the servo driver: a command is not left waiting for the next period, and too many do not hurry it."""

import threading
import time

from tendond.drivers.dynamixel.pace import EARLIEST, CommandPace

PERIOD = 0.2


def waited(pace: CommandPace, after: float | None, *, awaited: bool = True) -> float:
    """Time that the driver waits [s] if a command arrives `after` a time [s]; none: it has arrived already."""
    began = time.monotonic()
    if after is None:
        pace.arrived.set()
    else:
        timer = threading.Timer(after, pace.arrived.set)
        timer.daemon = True
        timer.start()
    pace.wait(awaited=awaited)
    return time.monotonic() - began


def test_a_command_is_sent_as_it_arrives_early_or_late() -> None:
    pace = CommandPace(PERIOD)
    early, late = waited(pace, 0.6 * PERIOD), waited(pace, 1.2 * PERIOD)
    assert 0.6 * PERIOD <= early < late
    assert late >= 1.2 * PERIOD


def test_without_a_command_the_driver_runs_on_and_while_none_is_awaited_by_its_period() -> None:
    pace = CommandPace(PERIOD)
    assert waited(pace, 10.0 * PERIOD) >= 1.5 * PERIOD - 1e-3
    assert not pace.arrived.is_set()
    pace = CommandPace(PERIOD)
    assert waited(pace, None, awaited=False) >= PERIOD - 1e-3


def test_commands_that_come_faster_do_not_hurry_it() -> None:
    pace = CommandPace(PERIOD)
    assert waited(pace, None) >= EARLIEST * PERIOD - 1e-3
