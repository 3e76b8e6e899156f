"""A Gymnasium environment: the tendons of a simulated robot, whose tip is to follow a target in space.

The plant is that of `tendond simulate`, servos, loads, camera and MuJoCo included, stepped without a clock. What is
observed and what an action does is what the law `policy` has in the controller (`daemon/control/laws/policy.py`), so
that a network which is trained here runs there; only the tip's velocity is by differences here, by the observer there.
"""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.laws.policy import KINEMATIC, observed
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import PlantRod, plant_rod
from tendond.model.errors import ConvergenceError
from tendond.offline.robustness.points import AXES
from tendond.offline.robustness.unlike import unlike
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.messages import TendonCommand

Array = NDArray[np.float64]

ROBOTS = 8
"""Robots that are drawn for an environment; each episode has one of them."""

MOVE_SECONDS = 1.0
"""Time in which the target moves from the tip at rest to its goal, along a line, by a polynomial of least jerk [s]."""

REACH = 0.6
"""Largest tension of the rests that goals are drawn from, as a part of limits.tension_max [-]."""

EFFORT = 0.01
"""Price of a full action, as a part of the robot's length in distance [-]."""

RATE = 2.0
"""Rate of a tension at an action of 1, in limits.tension_max a second [1/s]: the paper's step takes half of that."""

FACTORS = ("youngs_factor", "bending_damping_factor", "drag_factor")
"""Axes of the robustness study within which robots are drawn."""


class TendonEnv(gymnasium.Env[Array, Array]):
    """Follow a target with the tip.

    Observation, SI, base's frame, shape (12 + n,): position of the tip as the camera sees it [m], its velocity by
    differences [m/s], target [m], its velocity [m/s], tensions [N]. Action, shape (n,), -1..1: rate of each tension, as
    a part of `rate`; the tensions stay within pretension.tension_min and limits.tension_max. Reward: minus the distance
    of the true tip from the target by the robot's length, and minus `EFFORT` of the mean square action. An episode is
    truncated after `seconds`; it ends by itself only where the plant has no solution.

    Args:
        config: of the rig; its [simulator] is the plant.
        seconds: duration of an episode [s].
        randomise: draw robots with other stiffness, damping and drag, within the axes of the robustness study.

    Raises:
        ConfigError: simulator.drive is not 'tension'.

    Attributes:
        rate: of a tension at an action of 1 [N/s].
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - Gymnasium declares it so

    def __init__(self, config: RigConfig | None = None, seconds: float = 2.0, *, randomise: bool = True) -> None:
        self.config = RigConfig() if config is None else config
        if self.config.simulator.drive != "tension":
            raise ConfigError("simulator.drive = 'displacement': a policy acts on tensions: set it to 'tension'")
        self._period = self.config.loop.period
        self._low, self._high = self.config.pretension.tension_min, self.config.limits.tension_max
        self.rate = RATE * self._high
        self._cycles, self._randomise = round(seconds / self._period), randomise
        count = len(self.config.rod.tendon_positions)
        length = self.config.rod.backbone_length
        # no tip leaves a sphere of the robot's length; noise, and velocities, have room of ten
        bound = np.full(KINEMATIC + count, 10.0 * length)
        bound[3:6], bound[9:12], bound[KINEMATIC:] = 1e3 * length, 1e3 * length, 2.0 * self._high
        self.observation_space = gymnasium.spaces.Box(-bound, bound, dtype=np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (count,), dtype=np.float64)
        self._robots: dict[int, PlantRod] = {}
        self._tension = np.full(count, self._low)
        self._plant: Plant | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Put a robot at rest, draw a goal that it can rest at, and return the observation.

        Args:
            seed: of robot and goal. options: `goal`, position to move to instead [m], shape (3,).
        """
        super().reset(seed=seed)
        number = int(self.np_random.integers(ROBOTS)) if self._randomise else 0
        rod = self._robot(number)
        rod.load_tip(0.0)  # of the episode before
        self._plant = Plant(self._rig(number), rod)
        self._tension = np.full(len(self._tension), self._low)
        for _ in range(round(0.5 / self._period)):  # to rest under the pretension
            self._advance()
        self._cycle, self._begin = 0, np.array(self._plant.observe(0)[2].position)
        tensions = self.np_random.uniform(0.0, REACH * self._high, len(self._tension))
        drawn = rod.tip(rod.solve_static(tensions)).position
        self._goal = np.array((options or {}).get("goal", drawn), dtype=np.float64)
        self._velocity, self._position = np.zeros(3), self._begin
        return self._observe()[0], {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Change the tensions, advance by a cycle of the controller, and return what Gymnasium asks for.

        Args:
            action: shape (n,), clipped to -1..1.
        """
        wanted = np.clip(np.nan_to_num(np.asarray(action, dtype=np.float64)), -1.0, 1.0)
        self._tension = np.clip(self._tension + self.rate * self._period * wanted, self._low, self._high)
        self._cycle += 1
        try:
            self._advance()
        except ConvergenceError:
            return self._observe()[0], -1.0, True, False, {"error": float("nan")}
        observation, tip = self._observe()
        error = float(np.linalg.norm(tip - self._target()[0]))
        reward = -error / self.config.rod.backbone_length - EFFORT * float(np.mean(wanted**2))
        return observation, reward, False, self._cycle >= self._cycles, {"error": error}

    def _rig(self, number: int) -> RigConfig:
        """Return the rig of a robot, whose properties the number's own random numbers draw; 0 is the one configured."""
        section = self.config.simulator
        if number:
            random = np.random.default_rng(number)
            factors = [random.uniform(float(AXES[name][0]), float(AXES[name][-1])) for name in FACTORS]
            section = section.model_copy(update={"rod": unlike(section.rod, *factors), "seed": section.seed + number})
        return self.config.model_copy(update={"simulator": section})

    def _robot(self, number: int) -> PlantRod:
        if number not in self._robots:
            self._robots[number] = plant_rod(self._rig(number).simulator, self._period)
        return self._robots[number]

    def _advance(self) -> None:
        assert self._plant is not None
        tension = tuple(self._tension.tolist())
        self._plant.step(
            TendonCommand(seq=self._plant.seq, stamp_ns=0, pose_seq=None, displacement=(0.0,) * len(tension),
                          tension=tension, armed=True)
        )  # fmt: skip

    def _target(self) -> tuple[Array, Array]:
        """Return target [m] and its velocity [m/s] now, shape (3,) each."""
        s = min(1.0, self._cycle * self._period / MOVE_SECONDS)
        way = self._goal - self._begin
        rate = 30.0 * s**2 * (1.0 - s) ** 2 / MOVE_SECONDS
        return self._begin + s**3 * (10.0 - 15.0 * s + 6.0 * s**2) * way, rate * way

    def _observe(self) -> tuple[Array, Array]:
        """Return the observation and the true tip [m], shape (3,)."""
        assert self._plant is not None
        pose, _, truth = self._plant.observe(0)
        if pose is not None and pose.valid:
            new = np.array(pose.position)
            self._velocity = (new - self._position) / self._period if self._cycle else np.zeros(3)
            self._position = new
        seen = observed(self._position, self._velocity, *self._target(), self._tension)
        low, high = self.observation_space.low, self.observation_space.high  # type: ignore[attr-defined] # of a Box
        return np.clip(seen, low, high), np.array(truth.position)
