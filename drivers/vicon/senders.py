"""Selection of the sender whose packets are used, configured or the first one; others are counted and named. Pure."""

from collections import Counter
from dataclasses import dataclass, field

Sender = tuple[str, int]
"""IPv4 address and port."""

NAMED_MAX = 8
"""Largest number of senders that are named: forged addresses must not fill the journal."""

UNWELCOME = "of another sender"


@dataclass
class Senders:
    """Keep to one sender for as long as it sends.

    Attributes:
        only: address from which alone packets are taken; empty: that of whoever shows the robot's objects first.
        patience: silence of the kept sender after which another may take its place [s].
        section: name of the section, for messages.
        counts: packets that were passed over, by reason.
        news: lines for people that have not been fetched.
    """

    only: str
    patience: float
    section: str = "vicon"
    counts: Counter[str] = field(default_factory=Counter)
    news: list[str] = field(default_factory=list)
    _kept: Sender | None = None
    _heard: float = 0.0
    _named: set[Sender] = field(default_factory=set)

    def admit(self, sender: Sender, now: float) -> bool:
        """Return true for a sender whose packets are used.

        Args:
            sender: sender of a packet.
            now: monotonic clock [s].
        """
        if self.only and sender[0] != self.only:
            self._pass_over(sender, f"{self.section}.sender is {self.only}")
            return False
        if self._kept is None or sender == self._kept or now - self._heard > self.patience:
            return True
        self._pass_over(sender, f"{_text(self._kept)} sends the robot's objects, and was first")
        return False

    def keep(self, sender: Sender, now: float) -> None:
        """Keep an admitted sender that has shown one of the robot's objects."""
        if sender != self._kept:
            self.news.append(f"the robot's objects come from {_text(sender)}")
            self._named.clear()
        self._kept, self._heard = sender, now

    def _pass_over(self, sender: Sender, why: str) -> None:
        self.counts[UNWELCOME] += 1
        if sender not in self._named and len(self._named) < NAMED_MAX:
            self._named.add(sender)
            self.news.append(f"packets of {_text(sender)} are passed over: {why}")


def _text(sender: Sender) -> str:
    return f"{sender[0]}:{sender[1]}"
