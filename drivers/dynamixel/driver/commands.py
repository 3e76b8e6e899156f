"""Commands of the controller as the servo driver accepts them. Reads no clock.

After a start or a fault an armed command counts only after a disarmed one, so that a controller that was armed all
along does not take over in mid-motion.
"""

import math
from collections import Counter

from tendond.schemas.config.servo import ServoSection
from tendond.schemas.messages import TendonCommand


class CommandStream:
    """Newest command of the controller.

    Args:
        section: [servo].
        tendons: number of tendons.

    Attributes:
        newest: newest accepted command; none before the first.
        disarmed: a disarmed command has come since the start or the last fault.
        counts: unused and unusual commands, by reason.
    """

    def __init__(self, section: ServoSection, tendons: int) -> None:
        self._section = section
        self._tendons = tendons
        self._time = -math.inf
        self.newest: TendonCommand | None = None
        self.disarmed = False
        self.counts: Counter[str] = Counter()

    def take(self, command: TendonCommand, now: float) -> None:
        """Accept a command of the right size, newer than the last; a disarmed one may restart the count.

        Args:
            command: from the controller.
            now: monotonic time [s].
        """
        if len(command.displacement) != self._tendons:
            self.counts["wrong number of tendons"] += 1
            return
        if self.newest is not None and command.seq <= self.newest.seq and command.armed:
            self.counts["out of order"] += 1
            return
        if not command.armed:
            self.disarmed = True
        elif not all(map(self._within_range, command.displacement)):
            self.counts["beyond the range"] += 1
        self.newest, self._time = command, now

    def _within_range(self, displacement: float) -> bool:
        return self._section.displacement_min <= displacement <= self._section.displacement_max

    @property
    def armed(self) -> bool:
        """True where the newest command is an armed one."""
        return self.newest is not None and self.newest.armed

    def age(self, now: float) -> float:
        """Return the time since the newest command came [s]; infinite before the first."""
        return now - self._time

    def objection(self) -> str:
        """Explain why an armed command would not count; empty where it would."""
        if self.disarmed:
            return ""
        if not self.armed:
            return "the servos have received no command yet"
        return "the controller was armed before the servos were ready: stop it first"
