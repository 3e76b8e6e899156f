"""Dynamics of an actuator from goal to output: profile, lag, resolution, backlash."""

import math
from dataclasses import dataclass


@dataclass
class Actuator:
    """Actuator, in any unit of position.

    Attributes:
        rate: largest speed of its profile [unit/s]; 0: no limit.
        acceleration: acceleration of its profile [unit/s^2]; 0: no limit.
        lag: time constant of what follows the profile [s].
        resolution: smallest step [unit]; 0: none.
        backlash: travel that is lost when the direction changes [unit].
        position, velocity: state of the profile; shaft: position behind the lag; output: behind the play [unit].
    """

    rate: float = 0.0
    acceleration: float = 0.0
    lag: float = 0.0
    resolution: float = 0.0
    backlash: float = 0.0
    position: float = 0.0
    velocity: float = 0.0
    shaft: float = 0.0
    output: float = 0.0

    def place(self, position: float) -> None:
        """Set all positions, at rest."""
        self.position = self.shaft = self.output = position
        self.velocity = 0.0

    def step(self, goal: float, duration: float, friction: float = 0.0) -> float:
        """Return the output after `duration` [s] of moving to a goal.

        Args:
            goal: [unit].
            duration: [s].
            friction: half of the backlash that friction adds [unit].
        """
        self._profile(goal, duration)
        self.shaft += (self.position - self.shaft) * (-math.expm1(-duration / self.lag) if self.lag > 0.0 else 1.0)
        shaft = round(self.shaft / self.resolution) * self.resolution if self.resolution > 0.0 else self.shaft
        play = 0.5 * self.backlash + friction
        self.output = min(max(self.output, shaft - play), shaft + play)
        return self.output

    def _profile(self, goal: float, duration: float) -> None:
        distance = goal - self.position
        fastest = self.rate if self.rate > 0.0 else math.inf
        if self.acceleration <= 0.0:
            wanted = min(abs(distance) / duration, fastest)
            self.velocity = math.copysign(wanted, distance)
            self.position = goal if abs(distance) <= fastest * duration else self.position + self.velocity * duration
            return
        change = self.acceleration * duration
        braking = 0.5 * change  # the speed from which the next steps can still stop at the goal
        wanted = math.sqrt(braking * braking + 2.0 * self.acceleration * abs(distance)) - braking
        wanted = math.copysign(min(wanted, fastest, abs(distance) / duration), distance)
        self.velocity += min(max(wanted - self.velocity, -change), change)
        self.position += self.velocity * duration
        if abs(goal - self.position) < 1e-12 and abs(self.velocity) <= change:
            self.position, self.velocity = goal, 0.0
