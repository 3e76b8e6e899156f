"""Displacement of a tendon to position of its servo, and back."""

from dataclasses import dataclass

from tendond.drivers.dynamixel.calibration import TendonCalibration
from tendond.drivers.dynamixel.serial.table import LOAD_UNIT, TICK, TICKS_PER_TURN
from tendond.schemas.config.servo import STALL_TORQUE


@dataclass(frozen=True)
class Spool:
    """A tendon's spool; `turns` is what the servo has forgotten at power-up, or counts too many."""

    calibration: TendonCalibration
    turns: int = 0

    @property
    def _zero(self) -> int:
        return self.calibration.zero + self.turns * TICKS_PER_TURN

    def ticks(self, displacement: float) -> int:
        """Position for a displacement [m]."""
        return self._zero + round(self.calibration.sign * displacement / self.calibration.spool_radius / TICK)

    def displacement(self, ticks: int) -> float:
        """Displacement [m] at a position."""
        return self.calibration.sign * (ticks - self._zero) * TICK * self.calibration.spool_radius

    def tension(self, load: int) -> float:
        """Tension [N] by the servo's own estimate of its load; gears and friction make it a rough one."""
        return max(0.0, self.calibration.sign * load * LOAD_UNIT * STALL_TORQUE / self.calibration.spool_radius)
