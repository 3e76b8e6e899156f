"""Cycle of the servo driver: commands in, goals out, and its own reaction to every fault. Reads no clock.

off --armed--> on --command stream lost--> holding --> silent (no packets: the servos' watchdog stops them)
on or holding --fault--> stopped --> releasing --> off        on --disarmed--> releasing --> off
any --port gone--> lost

Loads are monitored in every phase: a tendon whose load rises during a release loses its torque. A fault lasts until it
is reset, and nothing is switched on before. After a start or a fault an armed command counts only after a disarmed one,
so that a controller that was armed all along does not take over in mid-motion.
"""

import math
from collections import Counter
from collections.abc import Callable, Mapping
from enum import StrEnum

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.guard import limited, standing_fault
from tendond.drivers.dynamixel.readings import BusHealth, bus_health
from tendond.drivers.dynamixel.serial.bus import NoAnswerError, PortLostError, ServoBus, ServoError
from tendond.drivers.dynamixel.session import ServoSession
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand

LOST_READS = "reads without an answer"


class DriverPhase(StrEnum):
    """Phase of the driver."""

    OFF = "off"
    ON = "on"
    HOLDING = "holding"
    SILENT = "silent"
    STOPPED = "stopped"
    RELEASING = "releasing tendons"
    LOST = "lost"


class ServoDriver:
    """Servos of a rig under a stream of commands.

    Args:
        section: [servo].
        calibration: complete.
        open_bus: opens the port.
        last: last known displacement of each tendon, by servo id [m].
        tension_max: that of [limits] [N]; limits loads and motor output.

    Raises:
        ServoError: the port cannot be opened, or the servos are not set up.

    Attributes:
        phase: see the module.
        fault: latched, in words; empty without one.
        objection: reason why the servos cannot be switched on now, in words; disappears with its cause.
        counts: unused commands and failed reads, by reason.
        places: last known displacement of each tendon, by servo id [m].
        session: the open bus with its servos.
    """

    def __init__(
        self,
        section: ServoSection,
        calibration: Calibration,
        open_bus: Callable[[], ServoBus],
        last: Mapping[int, float] | None = None,
        tension_max: float = math.inf,
    ) -> None:
        self._section = section
        self._tension_max = tension_max
        self._calibration = calibration
        self._open_bus = open_bus
        self.places = dict(last or {})
        self.phase = DriverPhase.OFF
        self.fault = ""
        self.objection = ""
        self.counts: Counter[str] = Counter()
        self._command: TendonCommand | None = None
        self._disarmed = False  # a disarmed command has come since the start or the last fault
        self._owns_torque = False
        self._was_on = False
        self._command_time = 0.0
        self._phase_since = 0.0
        self._last = 0.0
        self._unanswered = 0
        self._connect()

    def _connect(self) -> None:
        self.session = ServoSession(self._section, self._calibration, self._open_bus, self.places, self._tension_max)
        self.phase = DriverPhase.OFF
        self._unanswered = 0
        if self.session.holds:
            self.fault = "the servos still hold their tendons from an earlier run: run 'tendond servo home'"

    @property
    def displacement(self) -> tuple[float, ...]:
        """Displacement of the tendons at the last reading [m]."""
        return self.session.readings.displacement

    @property
    def tension(self) -> tuple[float, ...]:
        """Tension of the tendons at the last reading, as the servos estimate it [N]."""
        return self.session.readings.tension

    @property
    def late(self) -> tuple[int, float]:
        """Number of late answers so far, and the largest delay [s]."""
        return self.session.bus.late, self.session.bus.late_by

    @property
    def wire_seconds(self) -> float:
        """Duration of a read of all servos on the wire alone [s]."""
        return self.session.bus.wire_seconds(len(self.session.servos.ids))

    @property
    def health(self) -> BusHealth:
        """State of the serial bus; the round trips are those since the last call."""
        return bus_health(self.session.bus, self.counts[LOST_READS], self.session.readings)

    @property
    def report(self) -> str:
        """Fault or objection, for the controller."""
        return self.fault or self.objection

    @property
    def final_state(self) -> str:
        """State of the servos after `close`, in words."""
        if self.phase is DriverPhase.LOST:
            return "the port is gone, the servos were stopped by their watchdogs and may still hold their tendons"
        if self.session.holds and not self._was_on:
            return "the servos still hold their tendons from an earlier run: they were left as they are"
        return "the tendons are released, the torque is off"

    def cycle(self, now: float, command: TendonCommand | None) -> None:
        """Run one cycle.

        Args:
            now: monotonic time [s].
            command: newest one since the last cycle, if any.
        """
        duration, self._last = now - self._last, now
        if command is not None and self._accepts(command):
            self._command, self._command_time = command, now
        if self.phase in (DriverPhase.LOST, DriverPhase.SILENT):
            return
        try:
            self._act(now, duration)
            self._read(now)
        except PortLostError as error:
            self._enter(DriverPhase.LOST, now)
            self._fail(now, str(error))
        except ServoError as error:
            self._fail(now, str(error))

    def _accepts(self, command: TendonCommand) -> bool:
        """Accept a command of the right size, newer than the last; a disarmed one may restart the count."""
        if len(command.displacement) != len(self.session.servos.ids):
            self.counts["wrong number of tendons"] += 1
            return False
        if self._command is not None and command.seq <= self._command.seq and command.armed:
            self.counts["out of order"] += 1
            return False
        if not command.armed:
            self._disarmed = True
        elif not all(
            self._section.displacement_min <= one <= self._section.displacement_max for one in command.displacement
        ):
            self.counts["beyond the range"] += 1
        return True

    def _act(self, now: float, duration: float) -> None:
        """Change the phase where command or time ask for it, and send the goals."""
        command, section = self._command, self._section
        age = now - self._command_time
        if self.phase is DriverPhase.OFF:
            if command is not None and command.armed and age <= section.command_timeout:
                self._switch_on(now)
            return
        if self.phase is DriverPhase.ON and command is not None and not command.armed:
            self._enter(DriverPhase.RELEASING, now)
        if self.phase is DriverPhase.ON and age > section.command_timeout:
            self._enter(DriverPhase.HOLDING, now)
        if self.phase is DriverPhase.HOLDING:
            if age <= section.command_timeout:
                self._enter(DriverPhase.ON, now)
            elif now - self._phase_since > section.hold_time:
                self.fault = f"no command for {age:.2f} s: the servos' own watchdog stops them"
                self._enter(DriverPhase.SILENT, now)
                self._disarmed = False
                return
        if self.phase is DriverPhase.STOPPED and now - self._phase_since > section.fault_hold:
            self._enter(DriverPhase.RELEASING, now)
        if self.phase is DriverPhase.ON and command is not None:
            self.session.goals = limited(section, command.displacement, self.session.goals, duration)
        if self.phase is DriverPhase.RELEASING:
            released = self.session.step_release(duration)
            if released or now - self._phase_since > section.release_time:
                self._switch_off(now)
                return
        self.session.send(duration)

    def _read(self, now: float) -> None:
        """Read the servos and check them."""
        if self.phase is DriverPhase.SILENT:
            return
        session = self.session
        try:
            session.readings.read(now, relocate=self.phase is DriverPhase.OFF)
        except NoAnswerError as error:
            self._unanswered += 1
            self.counts[LOST_READS] += 1
            if self._unanswered == self._section.silent_reads:
                silent = session.bus.absent(session.servos.ids)
                names = ", ".join(map(str, silent))
                fault = f"servo {names}: does not answer" if silent else f"bad answers: {error}"
                self._fail(now, fault + session.bus.lateness)
            return
        self._unanswered = 0
        if self.phase is not DriverPhase.OFF:
            session.limit_output()
        if self.phase is DriverPhase.OFF:
            self.objection = session.objection() or self._not_disarmed()
            session.stand_still()
        elif self.phase is DriverPhase.STOPPED and session.overloaded:
            self._enter(DriverPhase.RELEASING, now)
        elif self.phase is DriverPhase.RELEASING:
            for said in session.drop_rising():
                self.fault = f"{self.fault}; {said}" if self.fault else said
                self._disarmed = False
        elif self.phase in (DriverPhase.ON, DriverPhase.HOLDING) and (fault := session.fault(now)):
            self._fail(now, fault)

    def _not_disarmed(self) -> str:
        """Explain why an armed command would not count; empty where it would."""
        if self._disarmed:
            return ""
        if self._command is None or not self._command.armed:
            return "the servos have received no command yet"
        return "the controller was armed before the servos were ready: stop it first"

    def _switch_on(self, now: float) -> None:
        if self.fault or self.objection or self._unanswered or not self._disarmed:
            return
        self.session.reset_monitors()
        self.session.stand_still()
        self._owns_torque = self._was_on = True
        self.session.servos.on(self.session.readings.servo)
        self._enter(DriverPhase.ON, now)

    def _fail(self, now: float, fault: str) -> None:
        """Latch a fault; servos that are on stop where they are, all together."""
        self.fault = self.fault or fault
        self._disarmed = False
        if self.phase in (DriverPhase.ON, DriverPhase.HOLDING):
            self._enter(DriverPhase.STOPPED, now)
            self.session.stop()

    def _enter(self, phase: DriverPhase, now: float) -> None:
        self.phase, self._phase_since = phase, now

    def _switch_off(self, now: float) -> None:
        self._enter(DriverPhase.OFF, now)
        try:
            self.session.servos.off()
            self._owns_torque = False
        except PortLostError:
            raise
        except ServoError as error:
            self.fault = self.fault or f"the torque may still be on: {error}"

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
        self._reconnect(now)  # a rebooted servo has lost its turns
        rebooted = f", servo {', '.join(map(str, alerted))} rebooted" if reboot and alerted else ""
        return self._reset_message(f"the fault is reset{rebooted}")

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
        return "the servos answer again: releasing the tendons"

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
