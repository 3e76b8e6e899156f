"""Servo driver: its cycle, the reset of a fault and the release at the end. Reads no clock."""

from collections.abc import Callable

from tendond.drivers.dynamixel.driver.cycle import ServoCycle
from tendond.drivers.dynamixel.driver.guard import standing_fault
from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.serial.bus import PortLostError, ServoError


class ServoDriver(ServoCycle):
    """Servos of a rig under a stream of commands, until it is closed."""

    @property
    def final_state(self) -> str:
        """State of the servos after `close`, in words."""
        if self.phase is DriverPhase.LOST:
            return "the port is gone, the servos were stopped by their watchdogs and may still hold their tendons"
        if self.session.holds and not self._was_on:
            return "the servos still hold their tendons from an earlier run: they were left as they are"
        return "the tendons are released, the torque is off"

    def reset(self, now: float, *, reboot: bool = False) -> str:
        """Leave a fault, on request: reopen a lost port, release what a silent bus still holds.

        Args:
            now: [s].
            reboot: reboot servos that report a hardware error; their torque is off by then.

        Returns:
            What was done, in one line.

        Raises:
            ServoError: the fault cannot be reset yet, and the reason.
        """
        if self.phase in (DriverPhase.STOPPED, DriverPhase.RELEASING):
            raise ServoError("the tendons are still being released")
        if self.phase is DriverPhase.LOST:
            self._reconnect(now)
            if self._owns_torque and all(reading.torque for reading in self.session.readings.servo):
                return self._release_after_silence(now)
            return self._reset_message("the port is open again")
        if self.phase is DriverPhase.SILENT:
            self.session.readings.read_again()
            return self._release_after_silence(now)
        if not self.fault:
            return "no fault"
        rebooted = self._clear_faults(reboot=reboot)
        self._reconnect(now)  # a rebooted servo has lost its turns
        return self._reset_message(f"the fault is reset{rebooted}")

    def _clear_faults(self, *, reboot: bool) -> str:
        """Check that no fault stands, rebooting servos that report one if asked; return which, in words."""
        servos = self.session.servos
        readings = servos.read_again()
        alerted = [one for one, reading in zip(servos.ids, readings, strict=True) if reading.alert]
        if reboot and alerted:
            servos.reboot(alerted)
            readings = servos.read_again()
        standing = standing_fault(self._section, servos.spools, readings)
        if standing:
            remedy = "fix its cause"
            if alerted and not reboot:
                remedy += ", then 'tendond servo reset --reboot'"
            raise ServoError(f"{standing}; {remedy}")
        return f", servo {', '.join(map(str, alerted))} rebooted" if reboot and alerted else ""

    def _reset_message(self, done: str) -> str:
        if self.fault:
            raise ServoError(self.fault)
        return done

    def _reconnect(self, now: float) -> None:
        self.session.bus.close()
        before, self.fault = self.fault, ""
        try:
            self._connect()
        except ServoError as error:
            self._enter(DriverPhase.LOST, now)
            self.fault = str(error) if isinstance(error, PortLostError) else f"{before}; {error}"
            raise

    def _release_after_silence(self, now: float) -> str:
        """Release tendons whose servos were stopped by their watchdog."""
        self.session.wake()
        self.fault = ""
        self._enter(DriverPhase.RELEASING, now)
        return "the servos reply again: releasing the tendons"

    def close(self, now: Callable[[], float], wait: Callable[[float], None]) -> None:
        """Release the tendons, switch the torque off, close the port.

        Args:
            now: the clock.
            wait: sleeps [s].

        Raises:
            ServoError: a servo may still have torque.
        """
        try:
            if self.phase is DriverPhase.SILENT:
                self.reset(now())
            if self.phase in (DriverPhase.ON, DriverPhase.HOLDING):
                self._enter(DriverPhase.RELEASING, now())
            while self.phase in (DriverPhase.STOPPED, DriverPhase.RELEASING):
                self.cycle(now(), None)
                wait(self._section.period)
        finally:
            try:
                if self._owns_torque:  # whatever failed before
                    self.session.servos.off()
            finally:
                self.session.bus.close()
