"""Tendons in the log of a run with servos: lag, error, load and speed."""

import math
from typing import Any

import numpy as np
import pytest

from tendond.offline.plots.wires import _lag, pace, wires, wires_table
from tendond.schemas.config.presets import WIRED
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, ServoHealth, TendonCommand, TendonState
from tendond.schemas.motors import XL430_W250

CYCLES, LAG = 300, 7
PEAK = 0.06


class Record:
    """The parts of a cycle's record that are read."""

    def __init__(self, number: int) -> None:
        def place(cycle: int) -> float:
            return 0.5 * PEAK * (1.0 - math.cos(2.0 * math.pi * max(cycle, 0) / CYCLES))

        self.mode = Mode.TRACKING
        self.tick = number
        self.command = TendonCommand(
            seq=number, stamp_ns=0, pose_seq=None, displacement=(place(number), 0.0), tension=(0.0, 0.0), armed=True
        )
        state = TendonState(
            seq=number,
            stamp_ns=0,
            displacement=(place(number - LAG) + 1e-4, 0.0),
            tension=(40.0 * place(number) / PEAK, 0),
        )
        self.inputs = type("Inputs", (), {"tendon_state": state})()


class Log:
    """A run of two tendons, the first of which goes to and fro."""

    def __init__(self, servo: str = "[servo]\n") -> None:
        self.config = parse_config(WIRED + servo, "rig.toml")
        self.records = [Record(number) for number in range(CYCLES)]


def test_lag_error_and_load_of_a_tendon_are_found_again() -> None:
    log: Any = Log()
    moving, resting = wires(log)
    assert moving.lag == pytest.approx(LAG * log.config.loop.period)
    assert moving.error == pytest.approx(1e-4, rel=0.01)
    assert moving.travel == pytest.approx(PEAK, rel=1e-3)
    assert moving.rate == pytest.approx(math.pi * PEAK / (CYCLES * log.config.loop.period), rel=0.01)
    assert moving.load == pytest.approx(40.0 * 0.015 / XL430_W250.stall_torque, rel=1e-3)
    assert (resting.travel, resting.rate, resting.tension) == (0.0, 0.0, 0.0)


def test_a_cycle_without_a_report_makes_no_command_look_faster() -> None:
    whole: Any = Log()
    gapped: Any = Log()
    del gapped.records[CYCLES // 4]
    assert wires(gapped)[0].rate == pytest.approx(wires(whole)[0].rate, rel=1e-3)


def test_the_speed_limit_is_given_in_the_servos_own_figures() -> None:
    log: Any = Log()
    said = pace(log, wires(log))
    assert said.startswith("The servos limit the speed: 60.0 mm of tendon take 0.67 s at the 89.5 mm/s")
    assert "the maximum command was 63 mm/s, and 51 mm/s are left at the largest load" in said


def test_the_serial_line_is_in_the_caption_of_the_table() -> None:
    health = ServoHealth(
        seq=1, stamp_ns=0, reads=800, lost=3, late=1, late_by=0.02, round_trip=0.0042, round_trip_max=0.03,
        phase="on", load=(0.1, 0.0),
    )  # fmt: skip
    log: Any = Log()
    caption = str(wires_table(wires(log), health).caption)
    assert caption == (
        "serial line: 800 reads of all servos, 3 lost, 1 replies late; 4.2 ms round trip, 30.0 ms maximum"
    )


def test_a_run_without_servos_has_no_wires() -> None:
    log: Any = Log(servo="")
    assert wires(log) == []
    assert pace(log, []) == ""


def test_a_tendon_that_never_moves_has_no_lag() -> None:
    assert _lag(np.zeros(200), np.full(200, 1e-4)) == (0, 1e-4)
