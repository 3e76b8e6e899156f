"""The servo driver's cycle: commands in, goals out, and its own reaction to whatever goes wrong. Reads no clock.

off --armed--> on --command stream lost--> holding --> silent (the bus too: the servos' watchdog stops them)
on or holding --fault--> stopped --> letting out --> off        on --disarmed--> letting out --> off
any --port gone--> lost
Loads are watched in every phase: a tendon that pulls harder while it is let out is dropped.
A fault lasts until it is reset, and nothing is switched on before. After a start or a fault a disarmed command must
have come before an armed one counts: a controller that was armed all along is not taken up in mid-motion.
"""

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.guard import SLIP, Guard, ReleaseWatch, away_from_zero, let_out, limited, standing_fault
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import NoAnswerError, PortLostError, ServoBus, ServoError
from tendond.drivers.dynamixel.serial.reading import Reading
from tendond.drivers.dynamixel.servos import Servos
from tendond.drivers.dynamixel.turns import FURTHER, Located
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand


@dataclass(frozen=True)
class Health:
    """See `ServoHealth`."""

    reads: int
    lost: int
    late: int
    late_by: float
    round_trip: float
    round_trip_max: float
    load: tuple[float, ...]


class Phase(StrEnum):
    """Of the driver."""

    OFF = "off"
    ON = "on"
    HOLDING = "holding"
    SILENT = "silent"
    STOPPED = "stopped"
    LETTING_OUT = "letting out"
    LOST = "lost"


PWM_DECAY = 0.9
"""Of the commanded rate, that is left after a cycle: a tendon that lags catches up."""

PWM_START = 0.2
"""Of `servo.displacement_rate`, beyond the rate at which a tendon moves, for which its motor's output is allowed: it
speeds up from one reading to the next, and one that is caught has not the output to tear at what holds it."""


class ServoDriver:
    """A rig's servos under a stream of commands.

    Args:
        section: [servo].
        calibration: complete.
        open_bus: opens the port.
        last: displacement at which each tendon was last known to be, by servo id [m].
        tension_max: of [limits] [N]; bounds loads and motors.

    Raises:
        ServoError: the port or the servos are not as they have to be.

    Attributes:
        phase: see the module.
        fault: latched, in words; empty when there is none.
        objection: why the servos could not be switched on now, in words; goes away with its cause.
        counts: of commands that were not used, and reads that failed, by reason.
        displacement: of the tendons at the last reading [m], tension: by the servos' estimate [N].
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
        self._last_places = dict(last or {})
        self._tension_max = tension_max
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
        self._seen = 0.0
        self._unanswered = 0
        self._readings: tuple[Reading, ...] = ()
        self._rates: tuple[float, ...] = ()
        self._dropped: dict[int, str] = {}
        self._connect()

    def _connect(self) -> None:
        self._bus = self._open_bus()
        try:
            self._servos = Servos(self._section, self._calibration, self._bus, self._last_places, self._tension_max)
            self._readings = self._servos.read_again()
        except ServoError:
            self._bus.close()
            raise
        self._watch()
        self._goals = self._servos.displacements(self._readings)
        self._sent = self._goals
        self.phase = Phase.OFF
        self._connected = False
        self._note()
        self._connected = True
        self._unanswered = 0
        if any(reading.torque for reading in self._readings):
            self.fault = "the servos still hold their tendons from an earlier run: run 'tendond servo home'"

    def _watch(self) -> None:
        """Watch from now on, as if nothing had been seen before."""
        self._guard = Guard(self._section, self._servos.watchdog, self._servos.limits)
        self._release = ReleaseWatch(self._servos.limits, self._section.pretension_load)
        self._rates = self._moving = (0.0,) * len(self._servos.ids)
        self._dropped = {}

    def _note(self) -> None:
        """Take the readings over, and where the tendons are: not a place to which none can have gone in a cycle."""
        places = self._servos.displacements(self._readings)
        if self.phase is Phase.OFF and any(self._jumped(one, place) for one, place in self._each(places)):
            self._servos.locate(self._readings, self._last_places)  # a servo was rebooted: it has forgotten its turns
            places = self._servos.displacements(self._readings)
        self.displacement = places
        self.tension = self._servos.tensions(self._readings)
        for one, place in self._each(places):
            if one.certain and not self._jumped(one, place):
                self._last_places[one.spool.calibration.servo] = place

    def _each(self, places: tuple[float, ...]) -> Iterable[tuple[Located, float]]:
        return zip(self._servos.located, places, strict=True)

    def _jumped(self, one: Located, place: float) -> bool:
        """Whether a tendon is further from its last place than it can have gone."""
        tendon = one.spool.calibration
        return abs(place - self._last_places.get(tendon.servo, place)) > FURTHER * one.turn and self._connected

    @property
    def places(self) -> Mapping[int, float]:
        """Where each tendon is, or was last known to be, by servo id [m]."""
        return self._last_places

    @property
    def late(self) -> tuple[int, float]:
        """Answers that came too late so far, and how late the latest was [s]."""
        return self._bus.late, self._bus.late_by

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
            held = [one for index, one in enumerate(self.displacement) if index not in self._dropped]
            still = self._goals == before and max(held, default=0.0) < SLIP
            if still or now - self._phase_since > section.release_time:
                self._switch_off(now)
                return
        self._go(duration)

    def _go(self, duration: float) -> None:
        """Send the goals, and as much output as they need."""
        before, self._sent = self._sent, self._goals
        fastest = self._section.displacement_rate
        if duration > 0.0:
            wanted = (min(abs(b - a) / duration, fastest) for a, b in zip(before, self._goals, strict=True))
            self._rates = tuple(max(one, PWM_DECAY * rate) for one, rate in zip(wanted, self._rates, strict=True))
        allowed = (
            min(one, 1.1 * own + PWM_START * fastest) for one, own in zip(self._rates, self._moving, strict=True)
        )
        self._servos.bound(tuple(allowed), self._readings)
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
                fault = f"servo {names}: does not answer" if silent else f"bad answers: {error}"
                self._fail(now, fault + self._bus.lateness)
            return
        self._unanswered = 0
        before, since = self.displacement, now - self._seen
        self._seen = now
        self._note()
        if since > 0.0:
            self._moving = tuple(abs(b - a) / since for a, b in zip(before, self.displacement, strict=True))
        if self.phase is Phase.OFF:
            self.objection = (
                standing_fault(self._section, self._servos.spools, self._readings)
                or away_from_zero(self._section, self._servos.located, self._readings)
                or self._unheard()
            )
            self._goals = self._sent = self.displacement
        elif self.phase in (Phase.STOPPED, Phase.LETTING_OUT):
            self._watch_release(now)
        elif self.phase in (Phase.ON, Phase.HOLDING):
            fault = self._guard.fault(now, self._servos.spools, self._readings, self._goals)
            if fault:
                self._fail(now, fault)

    @property
    def wire_seconds(self) -> float:
        """What a read of all servos takes on the wire alone [s]."""
        return self._bus.wire_seconds(len(self._servos.ids))

    @property
    def health(self) -> Health:
        """How the serial bus does; the round trips are those since it was last asked for."""
        trips = sorted(self._bus.round_trips)
        self._bus.round_trips.clear()
        return Health(
            reads=self._bus.reads,
            lost=self.counts["reads without an answer"],
            late=self._bus.late,
            late_by=self._bus.late_by,
            round_trip=trips[len(trips) // 2] if trips else 0.0,
            round_trip_max=trips[-1] if trips else 0.0,
            load=tuple(one.load * table.LOAD_UNIT for one in self._readings),
        )

    def _watch_release(self, now: float) -> None:
        """Drop a tendon that pulls harder while it is let out; while tendons stand still, let out sooner."""
        loads = [abs(one.load) * table.LOAD_UNIT for one in self._readings]
        if self.phase is Phase.STOPPED:
            if any(load > limit for load, limit in zip(loads, self._servos.limits, strict=True)):
                self._enter(Phase.LETTING_OUT, now)
            return
        for index, why in self._release.rising(loads, self._goals).items():
            if index in self._dropped or not self._readings[index].torque:
                continue
            servo = self._servos.ids[index]
            self._dropped[index] = f"tendon {index} (servo {servo}): {why}"
            self.fault = f"{self.fault}; {self._dropped[index]}" if self.fault else self._dropped[index]
            self._disarmed = False
            self._servos.drop(index)

    def _unheard(self) -> str:
        if self._disarmed:
            return ""
        if self._command is None or not self._command.armed:
            return "the servos have heard no command yet"
        return "the controller was armed before the servos were ready: stop it first"

    def _switch_on(self, now: float) -> None:
        if self.fault or self.objection or self._unanswered or not self._disarmed:
            return
        self._watch()
        self._goals = self._sent = self.displacement
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

    def reset(self, now: float, *, reboot: bool = False) -> str:
        """Leave a fault, on request: open a lost port again, let out what a silent bus still holds.

        Args:
            now: [s].
            reboot: start servos anew that report a hardware error; their torque is off by then.

        Returns:
            What was done, in one line.

        Raises:
            ServoError: it cannot be left yet, and why.
        """
        if self.phase in (Phase.STOPPED, Phase.LETTING_OUT):
            raise ServoError("the tendons are still being let out")
        if self.phase is Phase.LOST:
            self._reconnect(now)
            if self._ours and all(reading.torque for reading in self._readings):
                return self._take_over(now)
            return self._outcome("the port is open again")
        if self.phase is Phase.SILENT:
            self._readings = self._servos.read_again()
            return self._take_over(now)
        if not self.fault:
            return "there is no fault"
        readings = self._servos.read_again()
        ill = [one for one, reading in zip(self._servos.ids, readings, strict=True) if reading.alert]
        if reboot and ill:
            self._servos.reboot(ill)
            readings = self._servos.read_again()
        standing = standing_fault(self._section, self._servos.spools, readings)
        if standing:
            remedy = "mend its cause, then 'tendond servo reset --reboot'" if ill and not reboot else "mend its cause"
            raise ServoError(f"{standing}; {remedy}")
        self._reconnect(now)  # a servo that was rebooted has forgotten its turns
        rebooted = f", servo {', '.join(map(str, ill))} rebooted" if reboot and ill else ""
        return self._outcome(f"the fault is reset{rebooted}")

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
        self._watch()
        self._goals = self._sent = self.displacement
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
