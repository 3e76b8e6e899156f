"""Emulated servos between controller and plant in lockstep: the wired rig without drivers, clock and packets."""

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.checks import profile_units
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.models import MODELS
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.simulator.lockstep import Wires
from tendond.drivers.wired.rig import SpooledServo
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand, TendonState

STEPS = 10
"""Steps of the servos in a cycle; their motion does not depend on them, the load that slows them does."""


class ServoWires:
    """Servos on spools as wires of `lockstep.watched_loop`.

    Args:
        section: [servo]; its profile is that of the servos.
        calibration: of the tendons.
        period: of the cycle [s].
        phase: part of the cycle after which a command reaches the servos, as their driver has its own period [-].
    """

    def __init__(self, section: ServoSection, calibration: Calibration, period: float, phase: float = 0.5) -> None:
        self._tendons = [SpooledServo(tendon, section) for tendon in calibration.tendons]
        self._spools = [Spool(tendon) for tendon in calibration.tendons]
        self._period = period
        self._before = round(STEPS * phase)
        velocity, acceleration = profile_units(MODELS[section.model], section)
        for tendon in self._tendons:
            tendon.servo.put(table.PROFILE_VELOCITY, velocity)
            tendon.servo.put(table.PROFILE_ACCELERATION, acceleration)

    @property
    def wires(self) -> Wires:
        """The servos as wires."""
        return Wires(command=self._move, report=self._load)

    def _move(self, command: TendonCommand) -> TendonCommand:
        """Move the servos for a cycle; return where their tendons' ends are, as the command to the plant."""
        for step in range(STEPS):
            if step == self._before and command.armed:
                for tendon, spool, goal in zip(self._tendons, self._spools, command.displacement, strict=True):
                    if not tendon.servo.energised:  # until then a tendon that sags turns its servo
                        tendon.servo.put(table.TORQUE_ENABLE, 1)
                    tendon.servo.put(table.GOAL_POSITION, spool.ticks(goal))
            for tendon in self._tendons:
                tendon.servo.advance(self._period / STEPS)
        ends = tuple(tendon.displacement for tendon in self._tendons)
        return command.model_copy(update={"displacement": ends, "armed": True})  # spools hold their tendons

    def _load(self, state: TendonState) -> TendonState:
        """Load the servos with the tendons' tension."""
        for tendon, tension in zip(self._tendons, state.tension, strict=True):
            tendon.tension = tension
        return state
