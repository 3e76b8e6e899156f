"""A tendon caught at full speed: how hard its servo pulls, by the stiffness of what holds it, in simulated time."""

import numpy as np
import pytest

from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.strength import GEAR_MARGIN, load_limit, speed_share
from tendond.schemas.motors import XL430_W250
from tests.rig.bench import section
from tests.rig.servos import RADIUS, REPLY_SECONDS
from tests.unit.drivers.stepped import SteppedBench

CAUGHT = 0.02
"""Displacement at which the tendon is caught [m]."""

FULL_TURN = 0.055
SPEED = 0.085
SLACK = (0.0, 0.0, 0.0, 0.0)


def bound(tension_max: float) -> float:
    """Largest tension [N] that a standing motor pulls with: servo.tension_margin, and what its gears may need."""
    return XL430_W250.stall_torque / RADIUS * (load_limit(section(), tension_max, RADIUS) + GEAR_MARGIN)


def pulls(monkeypatch: pytest.MonkeyPatch, stiffness: float, tension_max: float, caught: float) -> tuple[float, str]:
    """Pull tendon 0 at full speed until it is released; its largest tension [N], and the driver's fault."""
    bench = SteppedBench(section(reply_timeout=REPLY_SECONDS), tension_max, monkeypatch)
    servo = bench.servos[0]

    def tension(ticks: float) -> float:
        return stiffness * max(0.0, (ticks - 2048.0) * table.TICK * RADIUS - caught)

    servo.torque = lambda ticks: -RADIUS * tension(ticks)
    found = [0.0]
    for _ in range(5):
        bench.cycle(SLACK, armed=False)
    for number in range(400):
        goal = min(FULL_TURN, SPEED * bench.section.period * number)
        bench.cycle((goal, 0.0, 0.0, 0.0), armed=True, during=lambda: found.append(tension(servo.position)))
        if bench.driver.fault and bench.driver.phase is DriverPhase.OFF:
            break
    assert not servo.energised
    return max(found), bench.driver.fault


@pytest.mark.parametrize("tension_max", [10.0, 20.0, 40.0])
@pytest.mark.parametrize("stiffness", [5e3, 20e3])
def test_a_tendon_caught_at_full_speed_pulls_no_harder_than_a_standing_motor_may(
    monkeypatch: pytest.MonkeyPatch, stiffness: float, tension_max: float
) -> None:
    """Caught anywhere in a cycle, 17 N at 20 kN/m; with all the output for its speed it pulled 85 N for 20 N."""
    for caught in CAUGHT + np.linspace(0.0, SPEED * 0.01, 5):
        pulled, fault = pulls(monkeypatch, stiffness, tension_max, float(caught))
        assert "tendon 0 (servo 1): load" in fault
        assert tension_max < pulled < bound(tension_max) + 1.5


def test_a_release_that_pulls_a_stiff_tendon_ends_at_about_tension_max(monkeypatch: pytest.MonkeyPatch) -> None:
    """A wrong sign: after 3 mm the release pulls at 20 kN/m, at the default servo.release_rate."""
    bench = SteppedBench(section(reply_timeout=REPLY_SECONDS, release_rate=0.05), 20.0, monkeypatch)
    servo = bench.servos[0]

    def tension(ticks: float) -> float:
        return 20e3 * max(0.0, 0.012 - (ticks - 2048.0) * table.TICK * RADIUS)

    for _ in range(5):
        bench.cycle(SLACK, armed=False)
    for number in range(60):
        bench.cycle((min(0.015, 0.00085 * number), 0.0, 0.0, 0.0), armed=True)
    servo.torque = lambda ticks: RADIUS * tension(ticks)
    found = [0.0]
    while bench.driver.phase is not DriverPhase.OFF:
        bench.cycle(SLACK, armed=False, during=lambda: found.append(tension(servo.position)))
    assert "its load rises" in bench.driver.fault
    assert 10.0 < max(found) < 25.0
    assert not servo.energised


def test_what_is_stiffer_pulls_until_the_next_reading(monkeypatch: pytest.MonkeyPatch) -> None:
    """A cycle at 50 kN/m is 42 N: the bound is passed before a load has been read at all, by up to half a cycle."""
    pulled = [pulls(monkeypatch, 50e3, 20.0, float(one))[0] for one in CAUGHT + np.linspace(0.0, SPEED * 0.01, 5)]
    assert max(pulled) < bound(20.0) + 0.5 * 50e3 * SPEED * 0.01


def test_a_tendon_under_the_load_of_a_rod_keeps_its_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    """600 N/m up to 18 N of 20: no further behind than without a load."""
    behind = {}
    for stiffness in (0.0, 600.0):
        bench = SteppedBench(section(reply_timeout=REPLY_SECONDS), 20.0, monkeypatch)
        servo = bench.servos[0]

        def torque(ticks: float, stiffness: float = stiffness) -> float:
            return -RADIUS * stiffness * max(0.0, (ticks - 2048.0) * table.TICK * RADIUS)

        servo.torque = torque
        for _ in range(5):
            bench.cycle(SLACK, armed=False)
        errors = []
        for number in range(80):
            goal = min(0.03, SPEED * bench.section.period * number)
            bench.cycle((goal, 0.0, 0.0, 0.0), armed=True)
            errors.append(goal - bench.driver.displacement[0])
        assert bench.driver.fault == ""
        assert abs(errors[-1]) < 2e-4
        behind[stiffness] = max(errors)
    assert behind[600.0] < behind[0.0] + 1e-3


def test_the_output_for_speed_is_reduced_as_a_load_approaches_its_limit_and_sooner_where_it_rises() -> None:
    assert speed_share(0.2, 0.0, 0.3) == pytest.approx(1.0)
    assert speed_share(0.25, 0.0, 0.3) == pytest.approx(0.5)
    assert speed_share(0.3, 0.0, 0.3) == 0.0
    assert speed_share(0.1, 0.1, 0.3) == 0.0
    assert speed_share(0.2, -0.1, 0.3) == pytest.approx(1.0)
