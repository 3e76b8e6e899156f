"""The protocol of inputs by hand, and what they say."""

from typing import NamedTuple, Protocol, Self


class Wish(NamedTuple):
    """What the hand says now.

    Attributes:
        part: of the largest speed, from -1 to 1; zero without a deadman switch that is held.
        end: "hold" to end and hold the place, "stop" to release the tendons, "lost" where the input is gone; empty to
            go on.
    """

    part: float
    end: str = ""


class Hand(Protocol):
    """An input by hand; open inside its `with` block."""

    help: str

    def __enter__(self) -> Self:
        """Open it."""

    def __exit__(self, *_: object) -> None:
        """Close it, and leave it as it was."""

    def wait(self, seconds: float) -> Wish:
        """Read what comes within a time [s], and return what holds then."""
