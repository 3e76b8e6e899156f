"""Replies that came after their timeout: their number, the largest delay, and the likely cause."""

import time


class LateReplies:
    """Late replies of a line.

    Attributes:
        count: number of them so far.
        by: largest delay, from the last request [s].
    """

    def __init__(self) -> None:
        self.count = 0
        self.by = 0.0
        self._request_time = 0.0

    def request_sent(self) -> None:
        """Measure delays from now on."""
        self._request_time = time.monotonic()

    def note(self) -> None:
        """Count a reply that came after its timeout."""
        self.count += 1
        self.by = max(self.by, time.monotonic() - self._request_time)

    @property
    def text(self) -> str:
        """Late replies and their likely cause, in words; empty without any."""
        if not self.count:
            return ""
        return (
            f"; {self.count} replies came late, by up to {self.by * 1e3:.0f} ms: is the adapter's latency timer 1 ms?"
        )
