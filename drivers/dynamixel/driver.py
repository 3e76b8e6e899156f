"""The servo driver's cycle: commands in, goals out, and its own reaction to whatever goes wrong. Reads no clock.

off --armed--> on --command stream lost--> holding --> silent (the bus too: the servos' watchdog stops them)
on or holding --fault--> stopped --> letting out --> off        on --disarmed--> letting out --> off
any --port gone--> lost
A fault lasts until it is reset, and nothing is switched on before. After a start or a fault a disarmed command must
have come before an armed one counts: a controller that was armed all along is not taken up in mid-motion.
"""

from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from enum import StrEnum

from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.bus import NoAnswerError, PortLostError, Reading, ServoBus, ServoError
from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.guard import SLIP, Guard, away_from_zero, let_out, limited, standing_fault
from tendond.drivers.dynamixel.servos import Servos
from tendond.schemas.config_servo import ServoSection
from tendond.schemas.messages import TendonCommand


class Phase(StrEnum):
    """Of the driver."""

    OFF = "off"
    ON = "on"
    HOLDING = "holding"
    SILENT = "silent"
    STOPPED = "stopped"
    LETTING_OUT = "letting out"
    LOST = "lost"


class ServoDriver:
    """A rig's servos under a stream of commands.

    Args:
        section: [servo].
        calibration: complete.
        open_bus: opens the port.

    Raises:
        ServoError: the port or the servos are not as they have to be.

    Attributes:
        phase: see the module.
        fault: latched, in words; empty when there is none.
        objection: why the servos could not be switched on now, in words; goes away with its cause.
        counts: of commands that were not used, and reads that failed, by reason.
        displacement: of the tendons at the last reading [m], tension: by the servos' estimate [N].
    """

    def __init__(self, section: ServoSection, calibration: Calibration, open_bus: Callable[[], ServoBus]) -> None:
        self._section = section
        self._calibration = calibration
        self._open_bus = open_bus
        self.phase = Phase.OFF
        self.fault = ""
        self.objection = ""
        self.counts: Counter[str] = Counter()
        self._command: TendonCommand | None = None
        self._disarmed = False
        self._ours = False
        self._was_on = False
        self._heard = 0.0
        self._phase_since = 0.0
        self._last = 0.0
        self._unanswered = 0
        self._readings: tuple[Reading, ...] = ()
        self._connect()

    def _connect(self) -> None:
        self._bus = self._open_bus()
        try:
            self._servos = Servos(self._section, self._calibration, self._bus)
            self._readings = self._servos.read_again()
        except ServoError:
            self._bus.close()
            raise
        self._guard = Guard(self._section, self._servos.watchdog)
        self._goals = self._servos.displacements(self._readings)
        self._note()
        self._unanswered = 0
        self.phase = Phase.OFF
        if any(reading.torque for reading in self._readings):
            self.fault = "the servos still hold their tendons from an earlier run: run 'tendond servo home'"

    def _note(self) -> None:
        self.displacement = self._servos.displacements(self._readings)
        self.tension = self._servos.tensions(self._readings)

    def cycle(self, now: float, command: TendonCommand | None) -> None:
        """One cycle.

        Args:
            now: [s], of a clock that only goes forward.
            command: the newest one that has come since the last cycle, if any.
        """
        duration, self._last = now - self._last, now
        if command is not None and self._accepts(command):
            self._command, self._heard = command, now
        if self.phase in (Phase.LOST, Phase.SILENT):
            return
        try:
            self._act(now, duration)
            self._look(now)
        except PortLostError as error:
            self._enter(Phase.LOST, now)
            self._fail(now, str(error))
        except ServoError as error:
            self._fail(now, str(error))

    def _accepts(self, command: TendonCommand) -> bool:
        """A command of the right size, newer than the last; one that counts anew is a new controller's: disarmed."""
        if len(command.displacement) != len(self._servos.ids):
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
        command, section = self._command, self._section
        age = now - self._heard
        if self.phase is Phase.OFF:
            if command is not None and command.armed and age <= section.command_timeout:
                self._switch_on(now)
            return
        if self.phase is Phase.ON and command is not None and not command.armed:
            self._enter(Phase.LETTING_OUT, now)
        if self.phase is Phase.ON and age > section.command_timeout:
            self._enter(Phase.HOLDING, now)
        if self.phase is Phase.HOLDING:
            if age <= section.command_timeout:
                self._enter(Phase.ON, now)
            elif now - self._phase_since > section.hold_time:
                self.fault = f"no command for {age:.2f} s: the servos' own watchdog stops them"
                self._enter(Phase.SILENT, now)
                self._disarmed = False
                return
        if self.phase is Phase.STOPPED and now - self._phase_since > section.fault_hold:
            self._enter(Phase.LETTING_OUT, now)
        if self.phase is Phase.ON and command is not None:
            self._goals = limited(section, command.displacement, self._goals, duration)
        if self.phase is Phase.LETTING_OUT:
            taut = [abs(one.load) * table.LOAD_UNIT > section.pretension_load for one in self._readings]
            before, self._goals = self._goals, let_out(section, self._goals, duration, self.displacement, taut)
            still = self._goals == before and max(self.displacement) < SLIP
            if still or now - self._phase_since > section.release_time:
                self._switch_off(now)
                return
        self._servos.go(self._goals)

    def _look(self, now: float) -> None:
        """Read the servos, and judge what they say."""
        if self.phase is Phase.SILENT:
            return
        try:
            self._readings = self._servos.read()
        except NoAnswerError as error:
            self._unanswered += 1
            self.counts["reads without an answer"] += 1
            if self._unanswered == self._section.silent_reads:
                silent = self._bus.absent(self._servos.ids)
                names = ", ".join(map(str, silent))
                self._fail(now, f"servo {names}: does not answer" if silent else f"bad answers: {error}")
            return
        self._unanswered = 0
        self._note()
        if self.phase is Phase.OFF:
            self.objection = (
                standing_fault(self._section, self._servos.spools, self._readings)
                or away_from_zero(self._section, self._servos.spools, self._readings)
                or self._unheard()
            )
            self._goals = self.displacement
        elif self.phase in (Phase.ON, Phase.HOLDING):
            fault = self._guard.fault(now, self._servos.spools, self._readings, self._goals)
            if fault:
                self._fail(now, fault)

    def _unheard(self) -> str:
        if self._disarmed:
            return ""
        if self._command is None or not self._command.armed:
            return "the servos have heard no command yet"
        return "the controller was armed before the servos were ready: stop it first"

    def _switch_on(self, now: float) -> None:
        if self.fault or self.objection or self._unanswered or not self._disarmed:
            return
        self._guard = Guard(self._section, self._servos.watchdog)
        self._goals = self.displacement
        self._ours = self._was_on = True
        self._servos.on(self._readings)
        self._enter(Phase.ON, now)

    def _fail(self, now: float, fault: str) -> None:
        """Latch a fault; servos that are on stop where they are, all together."""
        self.fault = self.fault or fault
        self._disarmed = False
        if self.phase in (Phase.ON, Phase.HOLDING):
            self._goals = tuple(
                min(max(goal, self._section.displacement_min), self._section.displacement_max)
                for goal in self.displacement
            )
            self._enter(Phase.STOPPED, now)
            with suppress(ServoError):  # the next cycle finds out
                if any(reading.watchdog == table.WATCHDOG_TRIPPED for reading in self._readings):
                    self._servos.wake(self._readings)  # else they would refuse to let out
                self._servos.go(self._goals)

    def _enter(self, phase: Phase, now: float) -> None:
        self.phase, self._phase_since = phase, now

    def _switch_off(self, now: float) -> None:
        self._enter(Phase.OFF, now)
        try:
            self._servos.off()
            self._ours = False
        except PortLostError:
            raise
        except ServoError as error:
            self.fault = self.fault or f"torque off is not certain: {error}"

    def reset(self, now: float) -> str:
        """Leave a fault, on request: open a lost port again, let out what a silent bus still holds.

        Returns:
            What was done, in one line.

        Raises:
            ServoError: it cannot be left yet, and why.
        """
        if self.phase in (Phase.STOPPED, Phase.LETTING_OUT):
            raise ServoError("the tendons are still being let out")
        if self.phase is Phase.LOST:
            turns = self._servos.spools
            self._reconnect(now)
            if self._ours and all(reading.torque for reading in self._readings):
                self._servos.spools = turns  # they have kept their torque, so they have kept count
                return self._take_over(now)
            return self._outcome("the port is open again")
        if self.phase is Phase.SILENT:
            self._readings = self._servos.read_again()
            return self._take_over(now)
        if not self.fault:
            return "there is no fault"
        standing = standing_fault(self._section, self._servos.spools, self._servos.read_again())
        if standing:
            raise ServoError(f"{standing}; mend it, and switch the servo's power off and on")
        self._reconnect(now)  # a servo whose power was switched has forgotten its turns
        return self._outcome("the fault is reset")

    def _outcome(self, done: str) -> str:
        if self.fault:
            raise ServoError(self.fault)
        return done

    def _reconnect(self, now: float) -> None:
        self._bus.close()
        before, self.fault = self.fault, ""
        try:
            self._connect()
        except ServoError as error:
            self._enter(Phase.LOST, now)
            self.fault = str(error) if isinstance(error, PortLostError) else f"{before}; {error}"
            raise

    def _take_over(self, now: float) -> str:
        """Servos that their watchdog has stopped, wound up as they are: let them out."""
        self._servos.wake(self._readings)
        self._note()
        self._goals = self.displacement
        self.fault = ""
        self._enter(Phase.LETTING_OUT, now)
        return "the servos are heard again: letting the tendons out"

    @property
    def report(self) -> str:
        """The fault or the objection, for the controller."""
        return self.fault or self.objection

    @property
    def farewell(self) -> str:
        """How the servos were left, after `close`, in words."""
        if self.phase is Phase.LOST:
            return "the port is gone, the servos were stopped by their watchdogs and may still hold their tendons"
        if any(reading.torque for reading in self._readings) and not self._was_on:
            return "the servos still hold their tendons from an earlier run: they were left as they are"
        return "the tendons are let out, the torque is off"

    def close(self, now: Callable[[], float], wait: Callable[[float], None]) -> None:
        """End: let out what is wound up, torque off, port closed.

        Args:
            now: the clock.
            wait: sleeps [s].

        Raises:
            ServoError: it cannot be told whether every servo is off.
        """
        try:
            if self.phase is Phase.SILENT:
                self.reset(now())
            if self.phase in (Phase.ON, Phase.HOLDING):
                self._enter(Phase.LETTING_OUT, now())
            while self.phase in (Phase.STOPPED, Phase.LETTING_OUT):
                self.cycle(now(), None)
                wait(self._section.period)
        finally:
            try:
                if self._ours:  # whatever went wrong on the way here
                    self._servos.off()
            finally:
                self._bus.close()
