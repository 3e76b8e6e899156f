"""Episodes, of one robot or of many together: robots, actions, the moving target, observations and rewards."""

from typing import NamedTuple

import gymnasium
import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.laws.policy import KINEMATIC
from tendond.offline.robustness.points import AXES
from tendond.offline.robustness.unlike import unlike
from tendond.schemas.config.rig import ConfigError, RigConfig

Array = NDArray[np.float64]

ROBOTS = 8
"""Robots that are drawn for an environment; each episode has one of them."""

MOVE_SECONDS = 1.0
"""Time in which the target moves from the tip at rest to its goal, along a line, by a polynomial of least jerk [s]."""

REST_SECONDS = 0.5
"""Time in which a robot comes to rest under the pretension, before an episode [s]."""

REACH = 0.6
"""Largest tension of the rests that goals are drawn from, as a part of limits.tension_max [-]."""

EFFORT = 0.01
"""Price of a full action, as a part of the robot's length in distance [-]."""

RATE = 2.0
"""Rate of a tension at an action of 1, in limits.tension_max a second [1/s]: the paper's step takes half of that."""

LOST = -1.0
"""Reward of a step in which the plant has no solution: as if the tip were the robot's length away."""

FACTORS = ("youngs_factor", "bending_damping_factor", "drag_factor")
"""Axes of the robustness study within which robots are drawn."""


class Draw(NamedTuple):
    """An episode's robot, by its number, and the tensions at whose rest its goal is [N], shape (n,)."""

    robot: int
    tensions: Array


class Task:
    """Episodes of a rig. Arrays have one row, or one a robot: shapes (..., 3) and (..., n).

    Args:
        config: of the rig; its [simulator] is the plant.
        seconds: duration of an episode [s].
        randomise: draw robots with other stiffness, damping and drag, within the axes of the robustness study.

    Attributes:
        period: of a step [s]. cycles: steps of an episode. tendons: their number, n.
        rate: of a tension at an action of 1 [N/s].
        observation_space, action_space: of one robot.

    Raises:
        ConfigError: simulator.drive is not 'tension'.
    """

    def __init__(self, config: RigConfig, seconds: float, *, randomise: bool) -> None:
        if config.simulator.drive != "tension":
            raise ConfigError("simulator.drive = 'displacement': a policy acts on tensions: set it to 'tension'")
        self.config, self._randomise = config, randomise
        self.period = config.loop.period
        self.cycles = round(seconds / self.period)
        self._low, self._high = config.pretension.tension_min, config.limits.tension_max
        self.rate = RATE * self._high
        self.tendons = len(config.rod.tendon_positions)
        length = config.rod.backbone_length
        # no tip leaves a sphere of the robot's length; noise, and velocities, have room of ten
        self._bound = np.full(KINEMATIC + self.tendons, 10.0 * length)
        self._bound[3:6], self._bound[9:12], self._bound[KINEMATIC:] = 1e3 * length, 1e3 * length, 2.0 * self._high
        self.observation_space = gymnasium.spaces.Box(-self._bound, self._bound, dtype=np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self.tendons,), dtype=np.float64)

    @property
    def rest_tension(self) -> Array:
        """Tensions with which an episode begins [N], shape (n,)."""
        return np.full(self.tendons, self._low)

    def draw(self, random: np.random.Generator) -> Draw:
        """Draw an episode."""
        robot = int(random.integers(ROBOTS)) if self._randomise else 0
        return Draw(robot, random.uniform(0.0, REACH * self._high, self.tendons))

    def rig(self, number: int) -> RigConfig:
        """Return the rig of a robot, whose properties the number's own random numbers draw; 0 is the one configured."""
        section = self.config.simulator
        if number:
            random = np.random.default_rng(number)
            factors = [random.uniform(float(AXES[name][0]), float(AXES[name][-1])) for name in FACTORS]
            section = section.model_copy(update={"rod": unlike(section.rod, *factors), "seed": section.seed + number})
        return self.config.model_copy(update={"simulator": section})

    def clipped(self, action: Array) -> Array:
        """Return an action within -1..1, finite."""
        return np.asarray(np.clip(np.nan_to_num(np.asarray(action, dtype=np.float64)), -1.0, 1.0))

    def pulled(self, tension: Array, action: Array) -> Array:
        """Return the tensions after a step of a clipped action [N]."""
        return np.asarray(np.clip(tension + self.rate * self.period * action, self._low, self._high))

    def target(self, cycle: Array, begin: Array, goal: Array) -> tuple[Array, Array]:
        """Return the target [m] and its velocity [m/s] at a cycle, shape (...), on the line from begin to goal [m]."""
        s = np.minimum(1.0, cycle * self.period / MOVE_SECONDS)[..., None]
        rate = 30.0 * s**2 * (1.0 - s) ** 2 / MOVE_SECONDS
        way = goal - begin
        return begin + s**3 * (10.0 - 15.0 * s + 6.0 * s**2) * way, rate * way

    def error(self, tip: Array, target: Array) -> Array:
        """Return the distance of the true tip from the target [m], shape (...)."""
        return np.asarray(np.sqrt(np.sum((tip - target) ** 2, axis=-1)))

    def reward(self, error: Array, action: Array) -> Array:
        """Return the reward of a step, shape (...), by the true tip's distance from the target [m] and the action."""
        return np.asarray(-error / self.config.rod.backbone_length - EFFORT * np.mean(action**2, axis=-1))

    def within(self, observation: Array) -> Array:
        """Return an observation within its space."""
        return np.asarray(np.clip(observation, -self._bound, self._bound))
