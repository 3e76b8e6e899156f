"""The servo driver's faults and limits on each kind of model, in simulated time: the SDK's real packets, no clock."""

import itertools
from collections.abc import Callable
from typing import Any

import pytest

from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.emulator.servo import EmulatedServo
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.serial.models import MODELS, model_of
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.strength import GEAR_MARGIN
from tendond.schemas.config.rig import ConfigError, parse_config
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.motors import MOTORS
from tests.rig.servos import RADIUS, hang_springs
from tests.unit.drivers.stepped import SteppedBench

KINDS: dict[str, dict[str, str | float]] = {
    "XL430": {"model": "XL430-W250-T"},
    "XM430 in mode 5": {"model": "XM430-W350", "current_limit": 0.4},
    "XL330": {"model": "XL330-M288", "tension_margin": 2.0},
    "PH42": {"model": "PH42-020-S300"},
}
"""One of each kind: without a measured current, with a limited one, of other units, and with other addresses."""

COARSE = 0.0025
"""Time step of the servos [s]."""

PULLED = (0.012, 0.0, 0.008, 0.0)
kinds = pytest.mark.parametrize("kind", KINDS)


def pulling(kind: str, monkeypatch: pytest.MonkeyPatch, tension_max: float = 20.0) -> SteppedBench:
    """Return a bench with two tendons pulled against springs."""
    bench = SteppedBench(ServoSection.model_validate(KINDS[kind]), tension_max, monkeypatch, COARSE)
    hang_springs(bench.servos, bench.calibration)
    for _ in range(3):
        bench.cycle((0.0,) * 4, armed=False)
    assert bench.driver.report == ""
    for _ in range(50):
        bench.cycle(PULLED, armed=True)
    assert bench.driver.phase is DriverPhase.ON, bench.driver.report
    assert bench.driver.displacement == pytest.approx(PULLED, abs=3e-4)
    return bench


def fails(bit: int) -> Callable[[EmulatedServo, ServoSection], None]:
    return lambda servo, section: servo.fail(bit)


def heats(servo: EmulatedServo, section: ServoSection) -> None:
    servo.temperature = section.temperature_max + 2.0


def browns(servo: EmulatedServo, section: ServoSection) -> None:
    servo.voltage = section.voltage_min - 0.3


def reboots(servo: EmulatedServo, section: ServoSection) -> None:
    servo.power_up()


def trips(servo: EmulatedServo, section: ServoSection) -> None:
    servo._store(table.BUS_WATCHDOG, table.WATCHDOG_TRIPPED)


def loads(servo: EmulatedServo, section: ServoSection) -> None:
    servo.torque = lambda ticks: -0.9 * section.motor.stall_torque


@kinds
@pytest.mark.parametrize(
    ("cause", "fault"),
    [
        (fails(5), "Overload Error (bit 5)"),
        (fails(1), "Motor Hall Sensor Error (bit 1)"),
        (heats, "degrees, servo.temperature_max is"),
        (browns, "V, allowed: "),
        (reboots, "its torque is off: it has been rebooted or has lost power"),
        (trips, "its Bus Watchdog has stopped it"),
        (loads, "(servo 3): load "),
    ],
)
def test_whatever_happens_to_a_servo_of_any_kind_stops_all_tendons_and_releases_them(
    kind: str, cause: Callable[[EmulatedServo, ServoSection], None], fault: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = pulling(kind, monkeypatch)
    cause(bench.servos[2], bench.section)
    for _ in range(round(1.0 / bench.section.period)):
        bench.cycle((0.03, 0.0, 0.03, 0.0), armed=True)
        if bench.driver.phase is not DriverPhase.ON:
            break
    assert bench.driver.phase in (DriverPhase.STOPPED, DriverPhase.RELEASING)
    assert "servo 3" in bench.driver.fault
    assert fault in bench.driver.fault
    first = []
    while bench.driver.phase in (DriverPhase.STOPPED, DriverPhase.RELEASING):
        first.append(bench.driver.session.goals[0])
        bench.cycle((0.03, 0.0, 0.03, 0.0), armed=True)
    assert all(after <= before + 1e-9 for before, after in itertools.pairwise(first))
    bench.cycle((0.03, 0.0, 0.03, 0.0), armed=True)
    assert bench.driver.phase is DriverPhase.OFF
    assert not any(servo.energised for servo in bench.servos)
    assert bench.driver.displacement[0] < 0.004


@kinds
def test_without_packets_the_watchdog_of_any_kind_stops_the_servo_and_refuses_goals(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = pulling(kind, monkeypatch)
    servo = bench.servos[0]
    servo.advance(0.9 * bench.section.watchdog)
    assert servo.value(table.BUS_WATCHDOG) != table.WATCHDOG_TRIPPED
    servo.advance(0.2 * bench.section.watchdog)
    assert servo.value(table.BUS_WATCHDOG) == table.WATCHDOG_TRIPPED
    before = servo.value(table.GOAL_POSITION)
    bus = bench.driver.session.bus
    assert isinstance(bus, ServoBus)
    with pytest.raises(ServoError, match="write Goal Position"):
        bus.write(1, table.GOAL_POSITION, before + 100)
    assert servo.value(table.GOAL_POSITION) == before
    assert servo.energised


@pytest.mark.parametrize("kind", ["XM430 in mode 5", "PH42"])
def test_a_jammed_tendon_is_pulled_with_the_limited_current_at_most(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A wall of 200 kN/m at 14 mm, and a goal behind it; by its voltage alone each motor could pull 270 N or more."""
    bench = pulling(kind, monkeypatch)
    servo, tendon, motor = bench.servos[0], bench.calibration.tendons[0], bench.section.motor
    spool = Spool(tendon)
    servo.torque = lambda ticks: -200e3 * max(0.0, spool.displacement(round(ticks)) - 0.014) * RADIUS
    pulls = []
    for _ in range(60):
        bench.cycle((0.08, 0.0, 0.008, 0.0), armed=True, during=lambda: pulls.append(-servo.torque(servo.position)))
        if bench.driver.phase is not DriverPhase.ON:
            break
    amperes = bench.section.current_limit or (bench.driver.session.servos.limits[0] + GEAR_MARGIN) * motor.stall_current
    assert 0.5 * amperes * motor.torque_constant < max(pulls) < 1.2 * amperes * motor.torque_constant
    assert max(pulls) < 0.3 * motor.torque_max
    assert bench.driver.phase is not DriverPhase.ON
    assert "tendon 0 (servo 1)" in bench.driver.fault


def test_a_goal_current_that_was_lost_is_sent_again(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = pulling("PH42", monkeypatch)
    wanted = bench.servos[1].value(table.GOAL_CURRENT)
    assert 0 < wanted < bench.servos[1].value(table.CURRENT_LIMIT)
    bench.servos[1].put(table.GOAL_CURRENT, 4500)
    bench.cycle(PULLED, armed=True)
    bench.cycle(PULLED, armed=True)
    assert bench.servos[1].value(table.GOAL_CURRENT) == wanted


def test_a_servo_of_another_or_an_unknown_model_is_refused_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ServoError, match=r"^servo 2: is model 1020 \(XM430-W350\), not 1060 .*servo\.model"):
        mixed(1020, monkeypatch)
    with pytest.raises(
        ServoError, match=r"^servo 2: is model 350, not 1060 .*unknown: replace it by one of XL430"
    ) as one:
        mixed(350, monkeypatch)
    assert "\n" not in str(one.value)


def mixed(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Open a driver of XL430s on a line whose second servo reports another model."""
    plain = EmulatedServo.__init__

    def other(self: EmulatedServo, identifier: int, *args: Any, **more: Any) -> None:
        plain(self, identifier, *args, **more)
        if identifier == 2:
            self._store(table.MODEL, number)

    with monkeypatch.context() as patch:
        patch.setattr(EmulatedServo, "__init__", other)
        SteppedBench(ServoSection(), 20.0, monkeypatch)


def test_a_calibration_of_a_servo_with_other_positions_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = pulling("PH42", monkeypatch)
    tendons = tuple(one.model_copy(update={"ticks_per_turn": 4096}) for one in bench.calibration.tendons)
    bench.driver._calibration = bench.calibration.model_copy(update={"tendons": tendons})
    bench.driver.fault = "something"
    with pytest.raises(ServoError, match=r"servo 1: its calibration is of .* 4096 .* 607500: run 'tendond servo"):
        bench.driver._reconnect(0.0)


X_ADDRESSES = (63, 64, 70, 98, 100, 108, 112, 116, 132, 144, 146)
P_ADDRESSES = (63, 512, 518, 546, 548, 556, 560, 564, 580, 592, 594)
REGISTERS = (
    table.SHUTDOWN,
    table.TORQUE_ENABLE,
    table.HARDWARE_ERROR_STATUS,
    table.BUS_WATCHDOG,
    table.GOAL_PWM,
    table.PROFILE_ACCELERATION,
    table.PROFILE_VELOCITY,
    table.GOAL_POSITION,
    table.PRESENT_POSITION,
    table.PRESENT_INPUT_VOLTAGE,
    table.PRESENT_TEMPERATURE,
)

MANUAL = """
XL430-W250-T  | 1060 | 72 | 140 |  60 |  885 |     - |  265 | 52 |  640
XL330-M077    | 1190 | 70 |  70 |  35 |  885 |  1750 | 1620 | 53 |  400
XL330-M288    | 1200 | 70 |  70 |  35 |  885 |  1750 |  445 | 53 |  400
XC330-M288    | 1240 | 70 |  70 |  35 |  885 |  2352 |  350 | 52 | 1100
XC330-T288    | 1220 | 70 | 140 |  55 |  885 |   910 |  320 | 52 |  900
XC430-W150    | 1070 | 80 | 160 |  60 |  885 |     - |  460 | 52 |  460
XC430-W240    | 1080 | 80 | 160 |  60 |  885 |     - |  306 | 52 |  700
XM430-W210    | 1030 | 80 | 160 |  95 |  885 |  1193 |  330 | 52 |  800
XM430-W350    | 1020 | 80 | 160 |  95 |  885 |  1193 |  350 | 52 |  800
XM540-W150    | 1130 | 80 | 160 |  95 |  885 |  2047 |  230 | 52 |  800
XM540-W270    | 1120 | 80 | 160 |  95 |  885 |  2047 |  128 | 52 |  800
PH42-020-S300 | 2000 | 80 | 350 | 150 | 2009 |  4500 | 2920 | 58 |    0
PH54-100-S500 | 2010 | 80 | 350 | 150 | 2009 | 15900 | 2920 | 58 |    0
"""
"""Initial values by the manual's page of each model, typed from it and not from the driver's tables; gains of the P
series have none."""

COLUMNS = (
    table.MODEL,
    table.TEMPERATURE_LIMIT,
    table.MAX_VOLTAGE_LIMIT,
    table.MIN_VOLTAGE_LIMIT,
    table.PWM_LIMIT,
    table.CURRENT_LIMIT,
    table.VELOCITY_LIMIT,
    table.SHUTDOWN,
    table.POSITION_P_GAIN,
)


def test_addresses_and_initial_values_are_those_of_the_manual() -> None:
    rows = [[cell.strip() for cell in line.split("|")] for line in MANUAL.strip().splitlines()]
    assert [name for name, *_ in rows] == list(MODELS)
    for name, *values in rows:
        model = MODELS[name]
        assert tuple(model.entry(one).address for one in REGISTERS) == (
            P_ADDRESSES if name.startswith("P") else X_ADDRESSES
        )
        found = [str(model.entry(one).initial) if model.has(one) else "-" for one in COLUMNS]
        assert found == values, name


@pytest.mark.parametrize("name", MODELS)
def test_the_table_of_a_model_is_consistent_and_its_own(name: str) -> None:
    one = MODELS[name]
    spans = sorted((register.address, register.size) for register in one.registers)
    assert all(a + size <= b for (a, size), (b, _) in itertools.pairwise(spans))
    assert len({register.name for register in one.registers}) == len(one.registers)
    assert model_of(one.entry(table.MODEL).initial) is one
    assert one.motor is MOTORS[one.name]
    assert all(
        register.minimum <= register.initial <= register.maximum for register in one.registers if not register.read_only
    )
    assert len({request.length for request in one.requests}) == len(one.requests)
    velocity = one.entry(table.VELOCITY_LIMIT).initial * one.velocity_unit
    assert velocity == pytest.approx(one.motor.velocity_limit, rel=1e-3)
    ServoSection(model=one.name)


@pytest.mark.parametrize(
    ("text", "objection"),
    [
        ('model = "XL430-W250"', "servo.model"),
        ("current_limit = 1.0", "the XL430-W250-T does not measure its current; remove it, or use one of XL330-M077"),
        ('model = "XM430-W350"\ncurrent_limit = 3.3', r"3\.3 A is above the Current Limit of the XM430-W350, 3\.209 A"),
        ('model = "XL330-M288"\nbaudrate = 4500000', "the XL330-M288 has at most 4000000 bit/s"),
        ('model = "XL330-M288"\nvoltage_max = 12.0', r"XL330-M288 has a supply of 3\.7 to 6 V"),
        ('model = "PH42-020-S300"\nprofile_acceleration = 20.0', r"above the Acceleration Limit .*: 18\.79 rad/s\^2"),
        ('model = "PH42-020-S300"\nprofile_velocity = 3.2', r"above the servos' Velocity Limit .*: 3\.058 rad/s"),
    ],
)
def test_what_a_model_cannot_do_is_refused_with_the_configuration(text: str, objection: str) -> None:
    with pytest.raises(ConfigError, match=objection) as error:
        parse_config(f"[servo]\n{text}\n", "rig.toml")
    assert "\n" not in str(error.value)


def test_a_current_limit_bounds_the_tension_that_the_controller_may_ask_for() -> None:
    text = '[servo]\nmodel = "XM430-W350"\ncurrent_limit = 0.5\n[limits]\ntension_max = {}\n'
    parse_config(text.format(59.0), "rig.toml")
    strongest = 0.5 * 4.1 / 2.3 / RADIUS
    with pytest.raises(ConfigError, match=rf"0\.5 A of servo.current_limit, on .* make {strongest:.1f} N"):
        parse_config(text.format(60.0), "rig.toml")
