"""Displacement of a tendon to position of its servo, and back."""

from dataclasses import dataclass

from tendond.drivers.dynamixel.calibration import TendonCalibration
from tendond.drivers.dynamixel.serial.table import LOAD_UNIT
from tendond.schemas.motors import Motor


@dataclass(frozen=True)
class Spool:
    """Spool of a tendon; `turns` are whole turns that the servo lost at power-up, or counts in excess."""

    calibration: TendonCalibration
    turns: int = 0

    @property
    def _zero(self) -> int:
        return self.calibration.zero + self.turns * self.calibration.ticks_per_turn

    def ticks(self, displacement: float) -> int:
        """Return the position [ticks] for a displacement [m]."""
        return self._zero + round(
            self.calibration.sign * displacement / self.calibration.spool_radius / self.calibration.tick
        )

    def displacement(self, ticks: int) -> float:
        """Return the displacement [m] at a position [ticks]."""
        return self.calibration.sign * (ticks - self._zero) * self.calibration.tick * self.calibration.spool_radius

    def tension(self, load: int, motor: Motor) -> float:
        """Return the tension [N] from the servo's estimate of its load, which includes gears and friction."""
        return max(0.0, self.calibration.sign * load * LOAD_UNIT * motor.stall_torque / self.calibration.spool_radius)
