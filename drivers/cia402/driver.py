"""Servo driver for drives: the same cycle, phases, limits and faults, with the drives' own end. Reads no clock."""

from tendond.drivers.dynamixel.driver.driver import ServoDriver
from tendond.drivers.dynamixel.driver.phase import DriverPhase


class DriveDriver(ServoDriver):
    """Drives of a rig under a stream of commands, until it is closed."""

    @property
    def final_state(self) -> str:
        """State of the drives after `close`, in words."""
        if self.phase is DriverPhase.LOST:
            return "the CAN bus is gone, the drives stop themselves without the driver's heartbeat"
        return super().final_state

    def _release_after_silence(self, now: float) -> str:
        """Release tendons whose drives hold; where they have no torque, there is nothing to release."""
        if self.session.holds:
            return super()._release_after_silence(now)
        self.session.servos.off()
        self._owns_torque = False
        self.fault = ""
        self._enter(DriverPhase.OFF, now)
        return "the drives reply again, they have no torque"
