"""Rates for which the motors' output is allowed: those of the goals, but not far above the tendons' speed."""

from collections.abc import Sequence

RATE_DECAY = 0.9
"""Fraction of the commanded rate that is kept after a cycle, so that a tendon that lags catches up: half of it
is left after 7 cycles. Chosen; `pytest tests/unit/drivers/test_servo_contact.py` passes with it."""

START_RATE = 0.2
"""Allowed rate above the tendon's own, as a fraction of `servo.displacement_rate`: a tendon accelerates from one
reading to the next, and a caught one does not get the output to pull hard at what holds it."""

SPEED_MARGIN = 1.1
"""Factor on the tendon's measured speed, for the error of a difference of two readings."""


class OutputRates:
    """Allowed rate of each tendon, from its goals and its measured speed.

    Args:
        rate_max: `servo.displacement_rate` [m/s].
        goals: goals of the tendons [m].
    """

    def __init__(self, rate_max: float, goals: Sequence[float]) -> None:
        self._rate_max = rate_max
        self._goals = tuple(goals)
        self._rates = (0.0,) * len(goals)

    def restart(self, goals: Sequence[float]) -> None:
        """Begin at goals without motion [m]."""
        self._goals = tuple(goals)

    def reset(self) -> None:
        """Forget the rates of earlier goals."""
        self._rates = (0.0,) * len(self._goals)

    def allowed(self, goals: Sequence[float], duration: float, speed: Sequence[float]) -> tuple[float, ...]:
        """Return the rate for which each motor's output is allowed [m/s].

        Args:
            goals: new ones [m].
            duration: since the last goals [s].
            speed: measured, of the tendons [m/s].
        """
        before, self._goals = self._goals, tuple(goals)
        if duration > 0.0:
            wanted = (min(abs(b - a) / duration, self._rate_max) for a, b in zip(before, self._goals, strict=True))
            self._rates = tuple(max(one, RATE_DECAY * rate) for one, rate in zip(wanted, self._rates, strict=True))
        start = START_RATE * self._rate_max
        return tuple(min(one, SPEED_MARGIN * own + start) for one, own in zip(self._rates, speed, strict=True))
