"""Selection of the controller that a driver follows: the first, while it sends commands. Reads no clock."""

from tendond.schemas.messages import TendonCommand

FORGOTTEN_SECONDS = 1.0
"""Time without a command after which a controller counts as gone [s]."""


class FollowedController:
    """Controller whose commands are carried out; those of another one are refused and reported.

    With two armed controllers the tendons would move as neither expects. Both receive the refusal as a fault of the
    tendon driver: an armed controller then releases the tendons, an idle one refuses to arm.
    """

    def __init__(self) -> None:
        self._source: str | None = None
        self._heard = 0.0
        self._other: tuple[str, float] | None = None
        self.refused = 0

    def admits(self, command: TendonCommand, now: float) -> bool:
        """Return true for a command of the followed controller.

        Args:
            command: as received.
            now: monotonic time [s].
        """
        if self._source is None or command.source == self._source or now - self._heard > FORGOTTEN_SECONDS:
            if self._other is not None and self._other[0] == command.source:
                self._other = None
            self._source, self._heard = command.source, now
            return True
        self._other = (command.source, now)
        self.refused += 1
        return False

    def objection(self, now: float) -> str:
        """Name another controller that sends commands, in words; empty without one."""
        if self._other is None or now - self._other[1] > FORGOTTEN_SECONDS:
            return ""
        return (
            f"commands of two controllers: {_name(self._source)} is followed, {_name(self._other[0])} is not; stop one"
        )


def _name(source: str | None) -> str:
    return f"'{source}'" if source else "one without a name"
