"""Which of several controllers a driver follows: the first that it hears, while that one speaks. Reads no clock."""

from tendond.schemas.messages import TendonCommand

FORGOTTEN_SECONDS = 1.0
"""Without a command for so long, a controller counts as gone."""


class FollowedController:
    """The controller whose commands are carried out; those of another one are refused, and it is named.

    A second controller that is armed makes the tendons do what neither expects. So what is refused is told to both,
    as a fault of the tendon driver: an armed controller then lets go, an idle one refuses to arm.
    """

    def __init__(self) -> None:
        self._source: str | None = None
        self._heard = 0.0
        self._other: tuple[str, float] | None = None
        self.refused = 0

    def admits(self, command: TendonCommand, now: float) -> bool:
        """Whether a command is of the followed controller.

        Args:
            command: as it came.
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
        """Who commands beside the followed controller, in words; empty if nobody does."""
        if self._other is None or now - self._other[1] > FORGOTTEN_SECONDS:
            return ""
        return (
            f"commands of two controllers: {_name(self._source)} is followed, {_name(self._other[0])} is not; end one"
        )


def _name(source: str | None) -> str:
    return f"'{source}'" if source else "one without a name"
