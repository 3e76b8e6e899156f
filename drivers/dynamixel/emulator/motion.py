"""Actuator of an emulated servo: the motion of `model.tendons.servo`, in ticks, with a state of its own."""

from tendond.model.tendons.servo import ServoDynamics, advance, at_rest


class Actuator:
    """Actuator from goal to shaft.

    Attributes:
        rate: largest speed of its profile [unit/s]; 0: no limit.
        acceleration: acceleration of its profile [unit/s^2]; 0: no limit.
        lag: time constant of what follows the profile [s].
        stall: load at which it stands [N m]; 0: none. no_load: speed without load [unit/s].
    """

    def __init__(self) -> None:
        self.rate = self.acceleration = self.lag = self.stall = self.no_load = 0.0
        self._state = at_rest(0.0)

    @property
    def position(self) -> float:
        """Position of the profile [unit]."""
        return self._state.position

    @property
    def velocity(self) -> float:
        """Velocity of the profile [unit/s]."""
        return self._state.velocity

    @property
    def shaft(self) -> float:
        """Position behind the lag [unit]."""
        return self._state.shaft

    def place(self, position: float) -> None:
        """Stand at `position` [unit]."""
        self._state = at_rest(position)

    def step(self, goal: float, duration: float, load: float = 0.0) -> None:
        """Move to `goal` [unit] for `duration` [s], under a load towards smaller positions [N m]."""
        servo = ServoDynamics(self.rate, self.acceleration, self.lag, stall=self.stall, no_load=self.no_load)
        self._state = advance(servo, self._state, goal, duration, load=load)
