"""Ratings of the motors that a servo driver knows, by model; their control tables are the driver's.

Each figure is of the ROBOTIS e-Manual, page of the model (`/docs/en/dxl/x/MODEL/`, `/docs/en/dxl/p/MODEL/`):
Specifications, and the initial values of Velocity Limit, Current Limit and Position P Gain in its control table.
"""

import math
from dataclasses import dataclass

RPM = 2.0 * math.pi / 60.0
"""One revolution per minute [rad/s]."""

UNKNOWN_STIFFNESS = 885.0 * 128.0 / 640.0 * 2.0 * math.pi / 4096.0
"""Position error with full output [rad] where the manual does not give the gain: that of the XL430. It widens margins,
and bounds nothing."""


@dataclass(frozen=True)
class Motor:
    """Ratings of a model.

    Attributes:
        name: name in the manual, without the suffix of its connector.
        number: Model Number, register 0.
        rated_volts: supply at which the following are given [V].
        stall_torque: torque at stall [N m]; of the P series, whose stall torque the manual does not give, the
            continuous torque. Loads are fractions of it.
        stall_current: current at that torque [A]; 0 where the model does not measure its current.
        no_load_speed: speed without load [rad/s].
        voltage: smallest and largest supply [V].
        temperature_limit: factory value of Temperature Limit [degree Celsius].
        velocity_limit: factory value of Velocity Limit [rad/s].
        acceleration_limit: factory value of Acceleration Limit [rad/s^2]; infinite where the model has none.
        current_max: factory value of Current Limit [A]; 0 without one.
        ticks_per_turn: positions in a turn.
        full_error: position error at which the position controller gives the full output [rad].
        continuous: `stall_torque` is the continuous torque: the motor can pull far more, only its current bounds it.
        baud_max: fastest baud rate [bit/s].
    """

    name: str
    number: int
    rated_volts: float
    stall_torque: float
    stall_current: float
    no_load_speed: float
    voltage: tuple[float, float]
    temperature_limit: float
    velocity_limit: float
    current_max: float = 0.0
    acceleration_limit: float = math.inf
    ticks_per_turn: int = 4096
    full_error: float = UNKNOWN_STIFFNESS
    continuous: bool = False
    baud_max: int = 4_500_000

    @property
    def limits_current(self) -> bool:
        """The model limits its current by a goal, while it controls its position."""
        return self.current_max > 0.0

    @property
    def torque_constant(self) -> float:
        """Torque per current, friction included [N m/A]; 0 where the current is not measured."""
        return self.stall_torque / self.stall_current if self.stall_current else 0.0

    @property
    def tick(self) -> float:
        """Unit of positions [rad]."""
        return 2.0 * math.pi / self.ticks_per_turn

    @property
    def torque_max(self) -> float:
        """Largest torque that it can pull with [N m]: at stall, or with the largest current."""
        return self.torque_constant * self.current_max if self.continuous else self.stall_torque


def _x(
    name: str,
    number: int,
    *,
    at: tuple[float, float, float, float],
    volts: tuple[float, float],
    degrees: float,
    velocity: int,
    gain: int,
    current: float = 0.0,
    baud_max: int = 4_500_000,
) -> Motor:
    """Make an X series motor.

    Args:
        name, number: see `Motor`.
        at: rated volts [V], stall torque [N m], its current [A], speed without load [rev/min].
        volts: supply [V].
        degrees: Temperature Limit [degree Celsius].
        velocity: Velocity Limit [0.229 rev/min].
        gain: Position P Gain; of 128, an error of a tick gives a 1/885 of the output (Position PID Gain).
        current: Current Limit [A].
        baud_max: [bit/s].
    """
    rated, torque, amperes, speed = at
    return Motor(
        name=name,
        number=number,
        rated_volts=rated,
        stall_torque=torque,
        stall_current=amperes if current else 0.0,
        no_load_speed=speed * RPM,
        voltage=volts,
        temperature_limit=degrees,
        velocity_limit=velocity * 0.229 * RPM,
        current_max=current,
        full_error=885.0 * 128.0 / gain * 2.0 * math.pi / 4096.0,
        baud_max=baud_max,
    )


def _p(
    name: str, number: int, *, torque: float, current: float, speed: float, ticks: int, acceleration: int, limit: float
) -> Motor:
    """Make a P series motor, at 24 V.

    Args:
        name, number: see `Motor`.
        torque, current: continuous ones [N m], [A].
        speed: without load [rev/min].
        ticks: positions in a turn.
        acceleration: Acceleration Limit [rev/min^2].
        limit: Current Limit [A].
    """
    return Motor(
        name=name,
        number=number,
        rated_volts=24.0,
        stall_torque=torque,
        stall_current=current,
        no_load_speed=speed * RPM,
        voltage=(15.0, 35.0),
        temperature_limit=80.0,
        velocity_limit=2920 * 0.01 * RPM,
        current_max=limit,
        acceleration_limit=acceleration * RPM / 60.0,
        ticks_per_turn=ticks,
        continuous=True,
    )


_LOW, _WIDE, _MIDDLE = (3.7, 6.0), (6.5, 14.8), (10.0, 14.8)

XL430_W250 = _x(
    "XL430-W250-T", 1060, at=(11.1, 1.4, 1.3, 57.0), volts=(6.5, 12.0), degrees=72.0, velocity=265, gain=640
)
"""Motor of a configuration that does not name one."""

_ALL = (
    XL430_W250,
    _x(
        "XL330-M077",
        1190,
        at=(5.0, 0.215, 1.47, 383.0),
        volts=_LOW,
        degrees=70.0,
        velocity=1620,
        gain=400,
        current=1.75,
        baud_max=4_000_000,
    ),
    _x(
        "XL330-M288",
        1200,
        at=(5.0, 0.52, 1.47, 103.0),
        volts=_LOW,
        degrees=70.0,
        velocity=445,
        gain=400,
        current=1.75,
        baud_max=4_000_000,
    ),
    _x(
        "XC330-M288",
        1240,
        at=(5.0, 0.93, 1.80, 81.0),
        volts=_LOW,
        degrees=70.0,
        velocity=350,
        gain=1100,
        current=2.352,
        baud_max=4_000_000,
    ),
    _x(
        "XC330-T288",
        1220,
        at=(11.1, 0.92, 0.80, 65.0),
        volts=(6.5, 12.0),
        degrees=70.0,
        velocity=320,
        gain=900,
        current=0.91,
        baud_max=4_000_000,
    ),
    _x("XC430-W150", 1070, at=(12.0, 1.6, 1.4, 106.0), volts=_WIDE, degrees=80.0, velocity=460, gain=460),
    _x("XC430-W240", 1080, at=(12.0, 1.9, 1.4, 70.0), volts=_WIDE, degrees=80.0, velocity=306, gain=700),
    _x(
        "XM430-W210",
        1030,
        at=(12.0, 3.0, 2.3, 77.0),
        volts=_MIDDLE,
        degrees=80.0,
        velocity=330,
        gain=800,
        current=1193 * 2.69e-3,
    ),
    _x(
        "XM430-W350",
        1020,
        at=(12.0, 4.1, 2.3, 46.0),
        volts=_MIDDLE,
        degrees=80.0,
        velocity=350,
        gain=800,
        current=1193 * 2.69e-3,
    ),
    _x(
        "XM540-W150",
        1130,
        at=(12.0, 7.3, 4.4, 53.0),
        volts=_MIDDLE,
        degrees=80.0,
        velocity=230,
        gain=800,
        current=2047 * 2.69e-3,
    ),
    _x(
        "XM540-W270",
        1120,
        at=(12.0, 10.6, 4.4, 30.0),
        volts=_MIDDLE,
        degrees=80.0,
        velocity=128,
        gain=800,
        current=2047 * 2.69e-3,
    ),
    _p("PH42-020-S300", 2000, torque=5.1, current=1.5, speed=32.7, ticks=607_500, acceleration=10_765, limit=4.5),
    _p("PH54-100-S500", 2010, torque=25.3, current=5.5, speed=33.3, ticks=1_003_846, acceleration=10_639, limit=15.9),
)

MOTORS = {motor.name: motor for motor in _ALL}
"""Motors by their name in `servo.model`."""
