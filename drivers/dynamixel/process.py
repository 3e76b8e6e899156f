"""Process of the servo driver: subscribes to commands, publishes tendon states, replies to `servo/reset`."""

import time
from collections import Counter
from dataclasses import asdict
from pathlib import Path

import zenoh

from tendond.bus.client import BusError, StoppedError, open_client
from tendond.bus.followed import FollowedController
from tendond.bus.identity import new_source
from tendond.bus.query import Queryable, replies, reply_to_next
from tendond.bus.subscription import Subscription
from tendond.drivers.dynamixel.calibration import Calibration, load_calibration
from tendond.drivers.dynamixel.driver.driver import ServoDriver
from tendond.drivers.dynamixel.driver.phase import DriverPhase
from tendond.drivers.dynamixel.pace import CommandPace
from tendond.drivers.dynamixel.places import PlaceKeeper, places_file, read_places
from tendond.drivers.dynamixel.serial.adapter import DELAYED_SECONDS, latency_warning
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.serial.late import LateReplies
from tendond.drivers.dynamixel.serial.models import MODELS
from tendond.drivers.host import Host, await_controller
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.keys import SERVO_HEALTH, SERVO_RESET, TENDON_COMMAND, TENDON_STATE, key
from tendond.schemas.messages import ENCODING, ServoHealth, TendonCommand, TendonState
from tendond.schemas.requests import ControlReply
from tendond.schemas.wire import encode

REPLY_SECONDS = 5.0
QUEUE = 8
HEALTH_SECONDS = 1.0
SAY_SECONDS = 10.0
"""Time between two lines about lost or late reads."""

REBOOT = b"reboot"
"""Payload of a `servo/reset` query that requests a reboot of servos with a hardware error."""


class ServoProcess:
    """Servo driver on the bus.

    Args:
        config: configuration of the rig.
        section: its [servo].
        folder: folder of the configuration, to which the calibration's path is relative.
        host: surroundings of the process.
    """

    awaits_commands = True
    """A cycle begins as soon as a command has come."""

    def __init__(
        self,
        config: RigConfig,
        section: ServoSection,
        folder: Path,
        host: Host,
    ) -> None:
        self._config = config
        self._section = section
        self._folder = folder
        self._host = host
        self._seq = 0
        self._source = new_source("servo")
        self._followed = FollowedController()

    def run(self) -> None:
        """Run until stopped; then the tendons are released and the torque is switched off.

        Raises:
            CalibrationError: there is none for this rig.
            BusError: no controller.
            ServoError: the servos are not set up, or may still have torque.
        """
        section = self._section
        ids = self._ids(len(self._config.rod.tendon_positions))
        calibration = load_calibration(self._folder / section.calibration, self._config.rig.name, ids)
        try:
            session = await_controller(self._config, self._host.stopped)
        except StoppedError:
            return
        file = places_file(self._folder, section)
        last = read_places(file, calibration)
        with session, PlaceKeeper(file, calibration, self._host.say) as keeper:
            driver = self._driver(calibration, last)
            motors = f"{len(calibration.tendons)} {self._motors}"
            ready = f"rig '{self._config.rig.name}': {motors} are ready, off"
            self._host.say(ready)
            self._host.supervisor.ready(ready)
            try:
                self._run(session, driver, keeper)
            finally:
                self._host.supervisor.stopping()
                driver.close(time.monotonic, time.sleep)
                keeper.keep(driver.places)
                self._host.say(f"stopped; {driver.final_state}")

    def _ids(self, tendons: int) -> tuple[int, ...]:
        """Return the id of each tendon's servo."""
        return self._section.servo_ids(tendons)

    def _driver(self, calibration: Calibration, last: dict[int, float]) -> ServoDriver:
        """Open the servos.

        Args:
            calibration: complete.
            last: last known displacement of each tendon, by servo id [m].
        """
        section = self._section

        def open_bus() -> ServoBus:
            return ServoBus(section.port, section.baudrate, section.reply_timeout, MODELS[section.model])

        driver = ServoDriver(section, calibration, open_bus, last, self._config.limits.tension_max)
        if warning := latency_warning(section.port):
            self._host.say(warning)
        return driver

    @property
    def _motors(self) -> str:
        """The motors and where they are, in words."""
        return f"servos on {self._section.port}"

    def _run(self, session: zenoh.Session, driver: ServoDriver, keeper: PlaceKeeper) -> None:
        name = self._config.rig.name
        pace = CommandPace(self._section.period)
        commands = Subscription(session, key(name, TENDON_COMMAND), TendonCommand, QUEUE, pace.arrived)
        resets = session.declare_queryable(key(name, SERVO_RESET), zenoh.handlers.RingChannel(QUEUE))
        states = session.declare_publisher(key(name, TENDON_STATE), encoding=ENCODING, express=True)
        reported, cleared, phase = "", "ready", driver.phase
        healths = session.declare_publisher(key(name, SERVO_HEALTH), encoding=ENCODING)
        before = health_time = time.monotonic()
        losses = ReadLossLog(before)
        while not self._host.stopped():
            driver.cycle(time.monotonic(), self._newest(commands, driver))
            states.put(encode(self._state(driver)))
            keeper.keep(driver.places)
            now = time.monotonic()
            bus = driver.session.bus  # another one after a reset
            if line := losses.line(now, driver.lost_reads, bus.transport.late):
                self._host.say(line)
            if now - health_time >= HEALTH_SECONDS:
                health_time = now
                health = self._health(driver)
                healths.put(encode(health))
                losses.note(health.round_trip - bus.read_seconds(len(driver.displacement)))
            if now - before <= self._section.watchdog:  # a lost port or a fault needs a person, not a restart
                self._host.supervisor.alive()
            before = now
            self._reset(resets, driver)
            if (report := self._report(driver)) != reported:
                reported = report
                waiting = bool(reported) and reported == driver.objection and not driver.fault
                self._host.say(f"{'not ready' if waiting else 'fault'}: {reported}" if reported else cleared)
                cleared = "ready" if waiting else "fault cleared"
            if driver.phase is not phase:
                phase = driver.phase
                self._host.say(f"servos: {phase.value}")
            pace.wait(awaited=self.awaits_commands and driver.phase is DriverPhase.ON)
        counts = driver.commands.counts + Counter({"reads without a reply": driver.lost_reads})
        if counts:
            self._host.say(", ".join(f"{count} {reason}" for reason, count in counts.items()))

    def _newest(self, commands: Subscription[TendonCommand], driver: ServoDriver) -> TendonCommand | None:
        newest: TendonCommand | None = None
        for command in commands:
            if self._followed.admits(command, time.monotonic()):
                newest = command
            else:
                driver.commands.counts["commands of another controller"] += 1
        driver.commands.counts.update(commands.unreadable)
        commands.unreadable.clear()
        return newest

    def _state(self, driver: ServoDriver) -> TendonState:
        self._seq += 1
        return TendonState(
            seq=self._seq,
            stamp_ns=time.monotonic_ns(),
            source=self._source,
            displacement=driver.displacement,
            tension=driver.tension,
            fault=self._report(driver),
        )

    def _report(self, driver: ServoDriver) -> str:
        """Return the driver's fault or objection, and a second controller."""
        return "; ".join(filter(None, (driver.report, self._followed.objection(time.monotonic()))))

    def _health(self, driver: ServoDriver) -> ServoHealth:
        return ServoHealth(
            seq=self._seq,
            stamp_ns=time.monotonic_ns(),
            source=self._source,
            phase=driver.phase.value,
            **asdict(driver.health),
        )

    def _reset(self, resets: Queryable, driver: ServoDriver) -> None:
        def reply_to(payload: bytes | None) -> ControlReply:
            try:
                return ControlReply(done=True, message=driver.reset(time.monotonic(), reboot=payload == REBOOT))
            except ServoError as error:
                return ControlReply(done=False, message=f"not reset: {error}")

        reply_to_next(resets, reply_to)


class ReadLossLog:
    """Lines about lost and late reads, at a bounded rate.

    Args:
        now: [s].
    """

    def __init__(self, now: float) -> None:
        self._since = now
        self._lost = self._late = 0
        self._slow = 0.0

    def note(self, beyond: float) -> None:
        """Note by how much reads take longer than on the wire alone [s]."""
        self._slow = beyond if beyond > DELAYED_SECONDS else 0.0

    def line(self, now: float, lost: int, late: LateReplies) -> str:
        """Return a line about reads lost or late since the last one; empty without any, or too early.

        Args:
            now: [s].
            lost: reads without a reply so far.
            late: late replies so far.
        """
        count = late.count
        if now - self._since < SAY_SECONDS or ((lost, count) == (self._lost, self._late) and not self._slow):
            return ""
        new, new_late, span = lost - self._lost, count - self._late, now - self._since
        self._since, self._lost, self._late = now, lost, count
        line = f"{new} reads without a reply in {span:.0f} s"
        if new_late > 0:
            line += f", {new_late} replies late, by up to {late.by * 1e3:.0f} ms"
        if self._slow:
            line += f", replies take {self._slow * 1e3:.0f} ms more than their time on the wire"
        return line + (": is the adapter's latency timer 1 ms?" if new_late > 0 or self._slow else "")


def request_reset(config: RigConfig, timeout: float = 1.0, *, reboot: bool = False) -> ControlReply:
    """Ask the servo driver to reset its fault, and optionally to reboot servos with a hardware error.

    Raises:
        BusError: there is no controller, or no servo driver.
    """
    with open_client(config.bus.endpoint, timeout) as session:
        payload = REBOOT if reboot else None
        for reply in replies(session, key(config.rig.name, SERVO_RESET), payload, REPLY_SECONDS, "servo driver"):
            return reply
    raise BusError(f"no servo driver of rig '{config.rig.name}' replies: start it with 'tendond servo'")
