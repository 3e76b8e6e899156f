"""A Gymnasium environment: the tendons of a simulated robot, whose tip is to follow a target in space.

The plant is that of `tendond simulate`, servos, loads, camera and MuJoCo included, stepped without a clock. What is
observed and what an action does is what the law `policy` has in the controller (`daemon/control/laws/policy.py`), so
that a network which is trained here runs there; only the tip's velocity is by differences here, by the observer there.
"""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.laws.policy import observed
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import PlantRod, plant_rod
from tendond.model.errors import ConvergenceError
from tendond.offline.learning.episode import LOST, REST_SECONDS, Task
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import TendonCommand

Array = NDArray[np.float64]


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
        task: what an episode is. rate: of a tension at an action of 1 [N/s].
    """

    metadata: dict[str, Any] = {"render_modes": []}  # noqa: RUF012 - Gymnasium declares it so

    def __init__(self, config: RigConfig | None = None, seconds: float = 2.0, *, randomise: bool = True) -> None:
        self.config = RigConfig() if config is None else config
        self.task = Task(self.config, seconds, randomise=randomise)
        self.rate = self.task.rate
        self.observation_space, self.action_space = self.task.observation_space, self.task.action_space
        self._robots: dict[int, PlantRod] = {}
        self._tension = self.task.rest_tension
        self._plant: Plant | None = None

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Put a robot at rest, draw a goal that it can rest at, and return the observation.

        Args:
            seed: of robot and goal. options: `goal`, position to move to instead [m], shape (3,).
        """
        super().reset(seed=seed)
        number, tensions = self.task.draw(self.np_random)
        rod = self._robot(number)
        rod.load_tip(0.0)  # of the episode before
        self._plant = Plant(self.task.rig(number), rod)
        self._tension = self.task.rest_tension
        for _ in range(round(REST_SECONDS / self.task.period)):
            self._advance()
        self._cycle, self._begin = 0, np.array(self._plant.observe(0)[2].position)
        drawn = rod.tip(rod.solve_static(tensions)).position
        self._goal = np.array((options or {}).get("goal", drawn), dtype=np.float64)
        self._velocity, self._position = np.zeros(3), self._begin
        return self._observe()[0], {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Change the tensions, advance by a cycle of the controller, and return what Gymnasium asks for.

        Args:
            action: shape (n,), clipped to -1..1.
        """
        wanted = self.task.clipped(action)
        self._tension = self.task.pulled(self._tension, wanted)
        self._cycle += 1
        try:
            self._advance()
        except ConvergenceError:
            return self._observe()[0], LOST, True, False, {"error": float("nan")}
        observation, tip = self._observe()
        error = self.task.error(tip, self._target()[0])
        reward = float(self.task.reward(error, wanted))
        return observation, reward, False, self._cycle >= self.task.cycles, {"error": float(error)}

    def _robot(self, number: int) -> PlantRod:
        if number not in self._robots:
            self._robots[number] = plant_rod(self.task.rig(number).simulator, self.task.period)
        return self._robots[number]

    def _advance(self) -> None:
        assert self._plant is not None
        self._plant.step(pulling(self._plant.seq, self._tension))

    def _target(self) -> tuple[Array, Array]:
        """Return target [m] and its velocity [m/s] now, shape (3,) each."""
        return self.task.target(np.asarray(self._cycle), self._begin, self._goal)

    def _observe(self) -> tuple[Array, Array]:
        """Return the observation and the true tip [m], shape (3,)."""
        assert self._plant is not None
        pose, _, truth = self._plant.observe(0)
        if pose is not None and pose.valid:
            new = np.array(pose.position)
            self._velocity = (new - self._position) / self.task.period if self._cycle else np.zeros(3)
            self._position = new
        seen = observed(self._position, self._velocity, *self._target(), self._tension)
        return self.task.within(seen), np.array(truth.position)


def pulling(seq: int, tension: Array) -> TendonCommand:
    """Return the command that pulls with tensions [N], shape (n,)."""
    pulls = tuple(tension.tolist())
    return TendonCommand(
        seq=seq, stamp_ns=0, pose_seq=None, displacement=(0.0,) * len(pulls), tension=pulls, armed=True
    )  # fmt: skip
