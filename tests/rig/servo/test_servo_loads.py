"""Loads in every phase, on emulated servos: what limits.tension_max allows, and a release that pulls instead."""

import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.strength import goal_pwm, load_limit
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.motors import XL430_W250
from tests.rig.bench import SLACK, DriverBench, section
from tests.rig.servos import RADIUS, emulated

pytestmark = pytest.mark.rig

TENSION_MAX = 20.0
STIFFNESS = 5_000.0
"""Stiffness of a tendon and of what has caught it [N/m]: 4 N more in each cycle at full speed."""


@pytest.fixture
def weak(tmp_path: Path) -> Iterator[DriverBench]:
    """Driver with limits.tension_max = 20 N."""
    with emulated(tmp_path) as servos:
        one = DriverBench(servos, tmp_path / "ttyUSB0", section(), TENSION_MAX)
        yield one
        one.driver.session.bus.close()


def hang(bench: DriverBench, index: int, slack: float, sign: int) -> list[float]:
    """Attach a stiff tendon that pulls once its spool has turned by `slack` [m] in a direction; return its tensions."""
    pulls: list[float] = []

    def torque(ticks: float) -> float:
        pulled = sign * (ticks - 2048.0) * table.TICK * RADIUS
        pull = STIFFNESS * max(0.0, pulled - slack)
        pulls.append(pull)
        return -sign * pull * RADIUS

    bench.servos.apply(lambda: setattr(bench.servos.servos[index], "torque", torque))
    return pulls


def test_a_load_beyond_tension_max_is_a_fault_long_before_load_max(weak: DriverBench) -> None:
    """The tendon is caught after 10 mm: the servo would pull with all it has."""
    pulls = hang(weak, 0, 0.010, 1)
    weak.until(lambda one: one.commands.disarmed, SLACK, armed=False)
    weak.until(
        lambda one: one.phase is DriverPhase.STOPPED or one.phase is DriverPhase.RELEASING, (0.03, 0.0, 0.0, 0.0)
    )
    assert "tendon 0 (servo 1): load" in weak.driver.fault
    assert "limit 32%" in weak.driver.fault
    weak.until(lambda one: one.phase is DriverPhase.OFF)
    assert 1.5 * TENSION_MAX < max(pulls) < 60.0  # load_max = 0.7 would allow 65 N, for load_time


def test_a_standing_servo_has_no_more_output_than_the_load_that_it_may_have(weak: DriverBench) -> None:
    weak.until(lambda one: one.commands.disarmed, SLACK, armed=False)
    weak.until(lambda one: one.displacement[0] > 0.0148, (0.015, 0.0, 0.0, 0.0))
    for _ in range(60):
        weak.driver.cycle(time.monotonic(), weak.command((0.015, 0.0, 0.0, 0.0)))
        time.sleep(0.01)
    wanted = goal_pwm(load_limit(weak.section, TENSION_MAX, RADIUS), RADIUS, 0.0, 12.0)
    assert [servo.value(table.GOAL_PWM) for servo in weak.servos.servos] == pytest.approx([wanted] * 4, abs=20)
    # a pull of 50 N cannot be held with it: the servo yields, and does not tear
    weak.servos.apply(lambda: setattr(weak.servos.servos[0], "torque", lambda ticks: -50.0 * RADIUS))
    before = weak.servos.servos[0].position
    time.sleep(0.1)
    assert weak.servos.servos[0].position < before


def test_output_and_load_are_shared_as_in_a_motor() -> None:
    settings = ServoSection()
    assert load_limit(settings, 20.0, 0.015) == pytest.approx(1.5 * 20.0 * 0.015 / XL430_W250.stall_torque)
    assert load_limit(settings, 60.0, 0.015) == settings.load_max
    assert load_limit(settings, 0.5, 0.015) == pytest.approx(1.5 * settings.pretension_load)
    still = goal_pwm(0.3, 0.015, 0.0, 11.1)
    half = goal_pwm(0.3, 0.015, 0.5 * XL430_W250.no_load_speed * 0.015, 11.1)
    assert still == pytest.approx(885 * 0.4, abs=1)
    assert half - still == pytest.approx(885 * 0.5, abs=1)
    assert goal_pwm(0.7, 0.015, 1.0, 11.1) == 885


def test_a_tendon_whose_load_rises_while_it_is_released_is_dropped_alone_and_named(weak: DriverBench) -> None:
    """The sign is wrong in the calibration: 'releasing' pulls a stiff tendon, after 3 mm of slack."""
    weak.until(lambda one: one.commands.disarmed, SLACK, armed=False)
    weak.until(lambda one: one.displacement[0] > 0.0148, (0.015, 0.0, 0.0, 0.0))
    pulls = hang(weak, 0, -0.012, -1)
    weak.until(lambda one: one.phase is DriverPhase.OFF, SLACK, armed=False)
    assert "tendon 0 (servo 1): its load rises" in weak.driver.fault
    assert "is its sign right?" in weak.driver.fault
    assert max(pulls) < 60.0
    assert pulls[-1] < 10.0  # without torque the gears hold up to a tenth of the stall torque: 9.3 N here
    assert not any(weak.torques)


def test_a_load_beyond_the_limit_does_not_wait_for_fault_hold(tmp_path: Path) -> None:
    with emulated(tmp_path) as servos:
        bench = DriverBench(servos, tmp_path / "ttyUSB0", section(fault_hold=5.0), TENSION_MAX)
        hang(bench, 0, 0.010, 1)
        bench.until(lambda one: one.commands.disarmed, SLACK, armed=False)
        bench.until(lambda one: bool(one.fault), (0.03, 0.0, 0.0, 0.0))
        began = time.monotonic()
        bench.until(lambda one: one.phase is DriverPhase.RELEASING)
        assert time.monotonic() - began < 1.0
        bench.driver.session.bus.close()
