"""Drives of a rig as a group, in the units of the servo driver: torque, goals, readings."""

import math
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from tendond.drivers.cia402 import objects
from tendond.drivers.cia402.bus import DriveBus
from tendond.drivers.cia402.setup import set_up
from tendond.drivers.cia402.states import (
    DISABLE_VOLTAGE,
    ENABLE_OPERATION,
    FAULT_BIT,
    FAULT_RESET,
    FOLLOWING_ERROR_BIT,
    POWERED,
    DriveState,
    state_of,
    towards_enabled,
)
from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import TRIES, NoReplyError, ServoError
from tendond.drivers.dynamixel.serial.reading import ServoReading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.strength import load_limit
from tendond.drivers.dynamixel.turns import Located
from tendond.schemas.config.drives import DrivesSection
from tendond.schemas.config.servo import ServoSection

ARMED = 1
"""Stands for an armed watchdog in a reading: a drive's heartbeat consumer shows in its state."""


class DriveGroup:
    """Drives of a rig on an open bus; the interface of `MotorGroup`.

    Args:
        drives: [drives].
        section: [servo].
        calibration: complete; a servo is a drive, its id the node id.
        bus: open.
        tension_max: limits.tension_max [N].

    Raises:
        ServoError: a drive is missing, is none, has not the mode, or refuses a setting.

    Attributes:
        located: place of each tendon: drives count their turns.
        spools: spools of the tendons.
        limits: largest load of each drive, as a fraction of its rated torque [-].
    """

    def __init__(
        self, drives: DrivesSection, section: ServoSection, calibration: Calibration, bus: DriveBus, tension_max: float
    ) -> None:
        self._drives, self._section, self._bus = drives, section, bus
        self._tendons = calibration.tendons
        self.ids = tuple(tendon.servo for tendon in calibration.tendons)
        self.watchdog = ARMED
        rated = drives.rated_torque
        self.limits = tuple(
            load_limit(section, tension_max, tendon.spool_radius, rated) for tendon in calibration.tendons
        )
        self.spools: tuple[Spool, ...] = tuple(map(Spool, calibration.tendons))
        self.located: tuple[Located, ...] = ()
        self._motor = replace(section.motor, stall_torque=rated)
        for tendon in calibration.tendons:
            if tendon.ticks_per_turn != drives.counts_per_turn:
                raise ServoError(
                    f"servo {tendon.servo}: its calibration has ticks_per_turn = {tendon.ticks_per_turn},"
                    f" drives.counts_per_turn is {drives.counts_per_turn}: correct one of them"
                )
        for index in range(len(self.ids)):
            self._set_up(index)
        self._owned: set[int] = set()
        self._words = dict.fromkeys(self.ids, DISABLE_VOLTAGE)
        self._targets = {node: bus.read(node, objects.POSITION) for node in self.ids}
        self.locate(self.read_again(), {})

    def _set_up(self, index: int) -> None:
        set_up(self._bus, self._drives, self._section, self._tendons[index], self.limits[index])

    def locate(self, readings: Sequence[ServoReading], last: Mapping[int, float]) -> None:
        """Take the places as the drives count them."""
        self.located = tuple(
            Located(spool, spool.displacement(reading.position))
            for spool, reading in zip(self.spools, readings, strict=True)
        )

    def _exchange(self) -> dict[int, tuple[int, int, int]]:
        return self._bus.exchange({node: (self._words[node], self._targets[node]) for node in self.ids})

    def read(self) -> tuple[ServoReading, ...]:
        """Exchange commands and states with all drives, in the order of the tendons.

        A drive that has left the state operation enabled is not enabled again, whatever its neighbours do.

        Raises:
            ServoError: not all of them replied.
        """
        received = self._exchange()
        if silent := [node for node in self.ids if node not in received]:
            raise NoReplyError(f"no reply from servo {', '.join(map(str, silent))}")
        readings = tuple(self._reading(node, *received[node]) for node in self.ids)
        for node in self.ids:
            if node in self._owned and state_of(received[node][0]) is not DriveState.ENABLED:
                self._words[node] = DISABLE_VOLTAGE
                if self._drives.stop == "hold" and state_of(received[node][0]) is DriveState.QUICK_STOP:
                    self._words[node] = ENABLE_OPERATION & ~0x4  # stays in quick stop, until it is released
        return readings

    def _reading(self, node: int, status: int, position: int, torque: int) -> ServoReading:
        state, trouble = state_of(status), ""
        if status & FAULT_BIT:
            trouble = f"fault {objects.error_name(self._bus.emergencies.get(node, 0))}"
        elif node in self._owned and state is not DriveState.ENABLED:
            trouble = f"has switched to '{state}' by itself: was the driver late, or its power cut?"
        elif status & FOLLOWING_ERROR_BIT and state is DriveState.ENABLED:
            trouble = "following error: is its tendon blocked?"
        section = self._section
        return ServoReading(
            torque=int(state in POWERED),
            hardware_error=0,
            watchdog=ARMED,
            goal=self._targets[node],
            load=torque,
            position=position,
            # supply and heat are the drive's own faults: these two are within their ranges
            voltage=round(0.5 * (section.voltage_min + section.voltage_max) / table.VOLTAGE_UNIT),
            temperature=0,
            alert=bool(status & FAULT_BIT),
            trouble=trouble,
        )

    def read_again(self) -> tuple[ServoReading, ...]:
        """Read all drives, several times where a reply is lost; a restarted drive is set up again.

        Raises:
            ServoError: not all of them replied.
        """
        for attempt in range(TRIES):
            with suppress(NoReplyError):
                return self.read()
            time.sleep(self._section.period)
            if attempt == 0:
                for node in self._bus.absent(self.ids):
                    self._owned.discard(node)
                    self._set_up(self.ids.index(node))
        return self.read()

    def _until(self, wanted: frozenset[DriveState], nodes: Sequence[int]) -> list[int]:
        """Exchange until drives are in one of the states; return those that are not in time."""
        late = list(nodes)
        for _ in range(max(2, round(self._drives.enable_time / self._section.period))):
            received = self._exchange()
            late = [node for node in nodes if node not in received or state_of(received[node][0]) not in wanted]
            if not late:
                break
            for node, (status, position, _torque) in received.items():
                if node in self._owned:
                    self._words[node] = towards_enabled(state_of(status))
                if state_of(status) is not DriveState.ENABLED:
                    self._targets[node] = position
            time.sleep(self._section.period)
        return late

    def on(self, readings: Sequence[ServoReading]) -> None:
        """Enable all drives at their present positions.

        Raises:
            ServoError: one does not get there in time; all of them are off again.
        """
        self._owned = set(self.ids)
        self._targets = {node: reading.position for node, reading in zip(self.ids, readings, strict=True)}
        try:
            for node in self.ids:
                mode = self._bus.read(node, objects.MODE_DISPLAY)
                if mode != objects.CYCLIC_POSITION:
                    raise ServoError(f"servo {node}: is in mode {mode}, not in {objects.CYCLIC_POSITION}")
            self._words = dict.fromkeys(self.ids, DISABLE_VOLTAGE)
            if late := self._until(frozenset({DriveState.ENABLED}), self.ids):
                raise ServoError(
                    f"servo {', '.join(map(str, late))}: not enabled within {self._drives.enable_time:g} s: is its"
                    " power stage supplied, its safe-torque-off input closed?"
                )
            self._words = dict.fromkeys(self.ids, ENABLE_OPERATION)
        except ServoError:
            with suppress(ServoError):
                self.off()
            raise

    def bound(self, rates: Sequence[float], readings: Sequence[ServoReading]) -> None:
        """Do nothing: the drive itself bounds its torque, by Max torque."""

    def wake(self, readings: Sequence[ServoReading]) -> None:
        """Take over drives that hold after their quick stop; those without torque stay so.

        Raises:
            ServoError: one does not get there in time.
        """
        self._targets = {node: reading.position for node, reading in zip(self.ids, readings, strict=True)}
        received = self._exchange()
        self._owned = {node for node, (status, *_) in received.items() if state_of(status) in (*POWERED[:2],)}
        for node in self.ids:
            self._words[node] = ENABLE_OPERATION if node in self._owned else DISABLE_VOLTAGE
        for _ in range(max(2, round(self._drives.enable_time / self._section.period))):
            states = {node: state_of(values[0]) for node, values in self._exchange().items()}
            if all(states.get(node) is DriveState.ENABLED for node in self._owned):
                return
            time.sleep(self._section.period)
        raise ServoError("the drives do not leave their quick stop: switch their power off by hand")

    def drop(self, index: int) -> None:
        """Disable one drive."""
        self._words[self.ids[index]] = DISABLE_VOLTAGE
        self._owned.discard(self.ids[index])

    def reboot(self, identifiers: Sequence[int]) -> None:
        """Reset the faults of drives.

        Raises:
            ServoError: one still has its fault.
        """
        for node in identifiers:
            self._words[node] = FAULT_RESET
            self._bus.emergencies.pop(node, None)
        self._exchange()
        for node in identifiers:
            self._words[node] = DISABLE_VOLTAGE
        if late := self._until(frozenset({DriveState.DISABLED, DriveState.READY}), identifiers):
            raise ServoError(f"servo {', '.join(map(str, late))}: keeps its fault: fix its cause")

    def go(self, goals: Sequence[float]) -> None:
        """Set the goal of each tendon [m]; the next `read` sends them.

        Raises:
            ServoError: a goal is not finite; the earlier goals stand.
        """
        if not all(map(math.isfinite, goals)):
            raise ServoError("a goal is not finite")
        for node, spool, goal in zip(self.ids, self.spools, goals, strict=True):
            self._targets[node] = spool.ticks(goal)

    def off(self) -> None:
        """Disable all drives, confirmed.

        Raises:
            ServoError: one may still have torque; all the others have none.
        """
        self._owned = set()
        self._words = dict.fromkeys(self.ids, DISABLE_VOLTAGE)
        without = frozenset(DriveState) - frozenset(POWERED)
        if late := self._until(without, self.ids):
            raise ServoError(f"servo {', '.join(map(str, late))}: does not confirm that its torque is off")

    def displacements(self, readings: Sequence[ServoReading]) -> tuple[float, ...]:
        """Return the displacement of each tendon [m]."""
        return tuple(spool.displacement(reading.position) for spool, reading in zip(self.spools, readings, strict=True))

    def tensions(self, readings: Sequence[ServoReading]) -> tuple[float, ...]:
        """Return the tension of each tendon, from Torque actual value [N]."""
        return tuple(
            spool.tension(reading.load, self._motor) for spool, reading in zip(self.spools, readings, strict=True)
        )
