"""Servos under load: the line of torque and speed in shared model, simulator, emulator and controller."""

import math

import numpy as np
import pytest

from tendond.daemon.control.actuation import limit_displacement
from tendond.daemon.control.reference.spatial import SpatialReference
from tendond.daemon.control.servos import configured_servo, pulling_rates
from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.simulator.lockstep import open_loop, watched_loop
from tendond.model.tendons.servo import ServoDynamics, advance, at_rest
from tendond.offline.drive.cases import CAMERA, CONFIGURED, REAL, Case, config_of
from tendond.schemas.config.rates import speed_line
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.motors import XL430_W250
from tendond.schemas.requests import ControlAction

SERVO = ServoDynamics(rate=0.2, acceleration=3.0, lag=0.02, stall=80.0, no_load=0.09)
FAR = 10.0


def speed(servo: ServoDynamics, load: float, goal: float) -> float:
    """Speed of a shaft that has been on its way to a goal for a second [m/s]."""
    state = advance(servo, at_rest(0.0), goal, 1.0, load=load)
    return (advance(servo, state, goal, 0.1, load=load).shaft - state.shaft) / 0.1


@pytest.mark.parametrize("load", [0.0, 20.0, 60.0, 79.0])
@pytest.mark.parametrize("acceleration", [0.0, 3.0])
def test_a_load_takes_away_speed_along_the_line(load: float, acceleration: float) -> None:
    servo = SERVO._replace(acceleration=acceleration, lag=0.02 if acceleration else 0.0)
    assert speed(servo, load, FAR) == pytest.approx(0.09 * (1.0 - load / 80.0), rel=1e-6)
    assert speed(servo, load, -FAR) == pytest.approx(-min(0.2, 0.09 * (1.0 + load / 80.0)), rel=1e-6)


def test_a_load_of_the_stall_torque_stops_it_and_less_lets_it_go_on() -> None:
    stalled = advance(SERVO, at_rest(0.0), FAR, 1.0, load=80.0)
    assert abs(stalled.shaft) < 1e-6
    assert advance(SERVO, stalled, FAR, 1.0, load=40.0).shaft > 0.03
    free = SERVO._replace(stall=0.0, no_load=0.0)
    assert advance(free, at_rest(0.0), FAR, 1.0, load=1e6) == advance(free, at_rest(0.0), FAR, 1.0)


@pytest.mark.parametrize(("volts", "torque", "rpm"), [(9.0, 1.0, 47.0), (11.1, 1.4, 57.0), (12.0, 1.5, 61.0)])
def test_the_line_is_the_manuals_at_its_three_voltages(volts: float, torque: float, rpm: float) -> None:
    """ROBOTIS e-Manual, XL430-W250-T, Specifications; its torque at 9 V is 12 % below proportion."""
    stall, no_load = speed_line(ServoSection(spool_radius=0.02), volts)
    assert stall * 0.02 == pytest.approx(torque, rel=0.02 if volts > 10.0 else 0.14)
    assert no_load / 0.02 == pytest.approx(rpm * 2.0 * math.pi / 60.0, rel=0.02)
    assert speed_line(None, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("volts", [10.0, 12.0])
@pytest.mark.parametrize("load", [0.0, 0.7])
def test_an_emulated_servo_is_as_fast_as_the_model_and_as_the_simulators(volts: float, load: float) -> None:
    servo = EmulatedServo(1)
    servo.voltage = volts
    servo.write(table.OPERATING_MODE.address, table.OPERATING_MODE.to_bytes(table.EXTENDED_POSITION))
    servo.write(table.PROFILE_ACCELERATION.address, table.PROFILE_ACCELERATION.to_bytes(0))
    servo.write(table.TORQUE_ENABLE.address, b"\x01")
    servo.torque = lambda _: -load
    servo.write(table.GOAL_POSITION.address, table.GOAL_POSITION.to_bytes(100_000))
    for _ in range(50):
        servo.advance(0.01)
    before = servo.position
    for _ in range(50):
        servo.advance(0.01)
    stall, no_load = speed_line(None, volts)
    radius = ServoSection().spool_radius
    line = no_load * (1.0 - load / radius / stall) / radius
    assert (servo.position - before) * table.TICK / 0.5 == pytest.approx(line, rel=1e-6)


def test_a_servo_whose_goal_pwm_is_half_has_half_the_line() -> None:
    found = []
    for duty in (1.0, 0.5):
        servo = EmulatedServo(1)
        servo.write(table.TORQUE_ENABLE.address, b"\x01")
        servo.write(table.GOAL_PWM.address, table.GOAL_PWM.to_bytes(round(duty * table.FULL_PWM)))
        servo.torque = lambda _: -0.3
        servo.write(table.GOAL_POSITION.address, table.GOAL_POSITION.to_bytes(4000))
        start = servo.position
        servo.advance(0.3)
        found.append((servo.position - start) * table.TICK)
    share = servo.voltage / 11.1
    expected = [XL430_W250.no_load_speed * (share * duty - 0.3 / XL430_W250.stall_torque) for duty in (1.0, 0.5)]
    assert found[1] / found[0] == pytest.approx(expected[1] / expected[0], rel=0.02)


def pulled_to(displacement: float, voltage: float) -> tuple[float, float]:
    """Displacement [m] and tension [N] of a simulated servo that has had ten seconds for its way."""
    config = check_config(
        {
            "simulator": {
                "drive": "displacement",
                "servo": {"voltage": voltage, "acceleration": 3.0},
                "rod": {"tendon_stiffness": 2e4, "gravity": [0.0, 0.0, 0.0]},
            }
        },
        "test",
    )
    command = TendonCommand(
        seq=0,
        stamp_ns=0,
        pose_seq=None,
        displacement=(displacement, -0.1, -0.1, -0.1),
        tension=(0.0,) * 4,
        armed=True,
    )
    state, _ = list(open_loop(config, [command] * 1000))[-1]
    return state.displacement[0], state.tension[0]


def test_a_simulated_servo_stalls_where_its_tendon_pulls_with_the_stall_torque() -> None:
    stall, _ = speed_line(None, 3.0)
    reached, tension = pulled_to(0.058, 3.0)
    assert tension == pytest.approx(stall, rel=0.05)
    assert reached < 0.05
    assert pulled_to(0.058, 12.0)[0] == pytest.approx(0.058, abs=1e-6)
    assert pulled_to(0.058, 0.0)[0] == pytest.approx(0.058, abs=1e-6)


def weak(voltage: float, configured: float) -> RigConfig:
    """The circle of 250 mm with servos at a voltage, which is configured in the controller."""
    case = Case("weak", {**REAL, "friction": 0.0}, CAMERA, CONFIGURED)
    config = config_of(case, 4.0)
    servo = config.simulator.servo.model_copy(update={"voltage": voltage})
    observer = config.observer.model_copy(update={"servo_voltage": configured})
    simulator = config.simulator.model_copy(update={"servo": servo})
    return config.model_copy(update={"simulator": simulator, "observer": observer})


def test_a_command_pulls_no_faster_than_the_load_allows_and_lets_out_as_before() -> None:
    config = weak(0.0, 6.0)
    servo = configured_servo(config)
    pulling = pulling_rates(servo, np.array([0.0, 25.0, 60.0, 25.0]))
    stall, no_load = speed_line(None, 6.0)
    assert pulling is not None
    assert pulling == pytest.approx([no_load, no_load * (1.0 - 25.0 / stall), 0.0, no_load * (1.0 - 25.0 / stall)])
    wanted, last = np.array([1.0, 1.0, 1.0, -1.0]), np.zeros(4)
    limits = config.limits.model_copy(update={"displacement_min": -2.0, "displacement_max": 2.0})
    command, met = limit_displacement(limits, 0.01, wanted, last, pulling)
    assert command[:3] == pytest.approx(0.01 * np.minimum(pulling[:3], limits.displacement_rate))
    assert command[3] == pytest.approx(-0.01 * limits.displacement_rate)
    assert "displacement rate" in met
    assert pulling_rates(configured_servo(weak(0.0, 0.0)), last) is None


def test_weak_servos_are_late_unless_their_voltage_is_configured() -> None:
    """At 4.5 V the tendons are too slow for the circle: the reference slows down to them."""
    worst = []
    for configured in (0.0, 4.5):
        config = weak(4.5, configured)
        reference = CycleSetup.from_config(config).selection.reference
        assert isinstance(reference, SpatialReference)
        assert ("the load of the servos" in " ".join(reference.notes)) == (configured > 0.0)
        cycles = 60 + math.ceil((config.pretension.duration + reference.arrival) / config.loop.period)
        run = list(watched_loop(config, cycles, {60: ControlAction.ARM}))
        tracked = [one for one in run if one.record.mode is Mode.TRACKING]
        apart = [math.dist(one.truth.position, one.record.reference.position) for one in tracked]
        worst.append(max(apart))
    assert worst[1] < 0.01
    assert worst[1] < 0.5 * worst[0]
