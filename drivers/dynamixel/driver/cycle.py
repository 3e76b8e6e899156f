"""Cycle of the servo driver: commands in, goals out, and its own reaction to every fault. Reads no clock.

Loads are monitored in every phase: a tendon whose load rises during a release loses its torque. A fault lasts until it
is reset, and nothing is switched on before.
"""

import math
from collections.abc import Callable, Mapping

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.driver.commands import CommandStream
from tendond.drivers.dynamixel.driver.guard import limited
from tendond.drivers.dynamixel.driver.motors import GroupMaker, MotorBus
from tendond.drivers.dynamixel.driver.phase import DriverPhase, next_phase
from tendond.drivers.dynamixel.driver.readings import BusHealth, bus_health
from tendond.drivers.dynamixel.driver.session import ServoSession
from tendond.drivers.dynamixel.serial.bus import NoReplyError, PortLostError, ServoError
from tendond.drivers.dynamixel.servos import ServoGroup
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand


class ServoCycle:
    """Servos of a rig under a stream of commands.

    Args:
        section: [servo].
        calibration: complete.
        open_bus: opens the port, or the bus of other motors.
        last: last known displacement of each tendon, by servo id [m].
        tension_max: limits.tension_max [N]; limits loads and motor output.
        make_group: makes the servos of the bus, or other motors.

    Raises:
        ServoError: the port cannot be opened, or the servos are not set up.

    Attributes:
        phase: see `phase`.
        fault: latched, in words; empty without one.
        objection: reason why the servos cannot be switched on now, in words; disappears with its cause.
        commands: those of the controller.
        lost_reads: number of reads without a reply.
        places: last known displacement of each tendon, by servo id [m].
        session: the open bus with its servos.
    """

    def __init__(
        self,
        section: ServoSection,
        calibration: Calibration,
        open_bus: Callable[[], MotorBus],
        last: Mapping[int, float] | None = None,
        tension_max: float = math.inf,
        make_group: GroupMaker = ServoGroup,
    ) -> None:
        self._make_group = make_group
        self._section = section
        self._tension_max = tension_max
        self._calibration = calibration
        self._open_bus = open_bus
        self.places = dict(last or {})
        self.phase = DriverPhase.OFF
        self.fault = ""
        self.objection = ""
        self.lost_reads = 0
        self.commands = CommandStream(section, len(calibration.tendons))
        self._owns_torque = False
        self._was_on = False
        self._phase_since = 0.0
        self._last = 0.0
        self._lost_in_a_row = 0
        self._connect()

    def _connect(self) -> None:
        self.session = ServoSession(
            self._section, self._calibration, self._open_bus, self.places, self._tension_max, self._make_group
        )
        self.phase = DriverPhase.OFF
        self._lost_in_a_row = 0
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
    def health(self) -> BusHealth:
        """State of the serial bus; the round trips are those since the last call."""
        return bus_health(self.session.bus, self.lost_reads, self.session.readings)

    @property
    def report(self) -> str:
        """Fault or objection, for the controller."""
        return self.fault or self.objection

    def cycle(self, now: float, command: TendonCommand | None) -> None:
        """Run one cycle.

        Args:
            now: monotonic time [s].
            command: newest one since the last cycle, if any.
        """
        duration, self._last = now - self._last, now
        if command is not None:
            self.commands.take(command, now)
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

    def _act(self, now: float, duration: float) -> None:
        """Change the phase where command or time ask for it, and send the goals."""
        commands, section = self.commands, self._section
        age = commands.age(now)
        if self.phase is DriverPhase.OFF:
            if commands.armed and age <= section.command_timeout:
                self._switch_on(now)
            return
        elapsed = now - self._phase_since
        phase = next_phase(section, self.phase, armed=commands.armed, age=age, elapsed=elapsed)
        if phase is not self.phase:
            self._enter(phase, now)
        if self.phase is DriverPhase.SILENT:
            self.fault = f"no command for {age:.2f} s: the servos' own watchdog stops them"
            commands.disarmed = False
            return
        if self.phase is DriverPhase.ON and commands.newest is not None:
            self.session.goals = limited(section, commands.newest.displacement, self.session.goals, duration)
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
        except NoReplyError as error:
            self._lost_in_a_row += 1
            self.lost_reads += 1
            if self._lost_in_a_row == self._section.silent_reads:
                silent = session.bus.absent(session.servos.ids)
                names = ", ".join(map(str, silent))
                fault = f"servo {names}: does not reply" if silent else f"bad replies: {error}"
                self._fail(now, fault + session.bus.transport.late.text)
            return
        self._lost_in_a_row = 0
        if self.phase is not DriverPhase.OFF:
            session.limit_output()
        if self.phase is DriverPhase.OFF:
            self.objection = session.objection() or self.commands.objection()
            session.stand_still()
        elif self.phase is DriverPhase.STOPPED and session.overloaded:
            self._enter(DriverPhase.RELEASING, now)
        elif self.phase is DriverPhase.RELEASING:
            for reason in session.drop_rising():
                self.fault = f"{self.fault}; {reason}" if self.fault else reason
                self.commands.disarmed = False
        elif self.phase in (DriverPhase.ON, DriverPhase.HOLDING) and (fault := session.fault(now)):
            self._fail(now, fault)

    def _switch_on(self, now: float) -> None:
        if self.fault or self.objection or self._lost_in_a_row or not self.commands.disarmed:
            return
        self.session.reset_monitors()
        self.session.stand_still()
        self._owns_torque = self._was_on = True
        self.session.servos.on(self.session.readings.servo)
        self._enter(DriverPhase.ON, now)

    def _fail(self, now: float, fault: str) -> None:
        """Latch a fault; servos that are on stop where they are, all together."""
        self.fault = self.fault or fault
        self.commands.disarmed = False
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
