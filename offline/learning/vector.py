"""Many environments in one call: what `TendonEnv` is for one robot, for N that are stepped as a batch of rods."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from tendond.offline.learning.episode import LOST, Task
from tendond.offline.learning.robots import Robots, batched
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


class TendonVectorEnv(VectorEnv[Array, Array, NDArray[Any]]):
    """Follow a target with the tips of N robots.

    Spaces, episodes, seeds and numbers are those of N `TendonEnv` with `simulator.solver = "general"`, to the last
    bit; see `robots` for what a plant may have. Observations have shape (N, 12 + n), actions (N, n), rewards (N,).
    `info["error"]` is the distance of the true tips from their targets [m], shape (N,).

    Args:
        count: number of robots, N.
        config, seconds, randomise: see `TendonEnv`.
        autoreset_mode: of Gymnasium: when an episode has ended, reset with the next step (its action is ignored, its
            reward 0), in the same step (`final_obs` and `final_info` are then in the info), or not.
        workers: threads that step the rods.

    Raises:
        ConfigError: the plant has what a batch does not carry, or displacement drives it.

    Attributes:
        task: what an episode is. rate: of a tension at an action of 1 [N/s].
    """

    def __init__(
        self,
        count: int,
        config: RigConfig | None = None,
        seconds: float = 2.0,
        *,
        randomise: bool = True,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        workers: int = 1,
    ) -> None:
        self.task = Task(batched(RigConfig() if config is None else config), seconds, randomise=randomise)
        self.rate, self.num_envs, self.autoreset_mode = self.task.rate, count, autoreset_mode
        self.metadata = {"render_modes": [], "autoreset_mode": autoreset_mode}
        self.single_observation_space, self.single_action_space = self.task.observation_space, self.task.action_space
        self.observation_space = batch_space(self.single_observation_space, count)
        self.action_space = batch_space(self.single_action_space, count)
        self._pool = ThreadPoolExecutor(workers) if workers > 1 else None
        self._robots = Robots(self.task, count, workers, map if self._pool is None else self._pool.map)
        self._randoms: list[np.random.Generator | None] = [None] * count
        self._tension = np.tile(self.task.rest_tension, (count, 1))
        self._cycle = np.zeros(count)
        self._begin, self._goal, self._position, self._velocity = (np.zeros((count, 3)) for _ in range(4))
        self._ended: Mask = np.ones(count, dtype=np.bool_)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Put robots at rest, draw goals that they can rest at, and return the observations.

        Args:
            seed: of robots and goals: of the first, the others' follow; or one each.
            options: `goal`, position to move to instead [m], shape (3,) or (N, 3); `reset_mask`, which of them, shape
                (N,).

        Raises:
            ValueError: not as many seeds, or as long a mask, as there are robots.
        """
        given = options or {}
        mask = np.asarray(given.get("reset_mask", np.ones(self.num_envs)), dtype=np.bool_)
        if seed is None or isinstance(seed, int):
            seed = [None if seed is None else seed + index for index in range(self.num_envs)]
        if len(seed) != self.num_envs or mask.shape != (self.num_envs,):
            raise ValueError(f"{len(seed)} seeds and a mask of shape {mask.shape}: must be of {self.num_envs} robots")
        for index in np.flatnonzero(mask).tolist():
            if seed[index] is not None or self._randoms[index] is None:
                self._randoms[index] = seeding.np_random(seed[index])[0]
        self._begin_episodes(mask, given.get("goal"))
        return self._observation(), {}

    def step(self, actions: Array) -> tuple[Array, Array, Mask, Mask, dict[str, Any]]:
        """Change the tensions, advance by a cycle of the controller, and return what Gymnasium asks for.

        Args:
            actions: shape (N, n), clipped to -1..1.

        Raises:
            ResetNeeded: an episode has ended, or none has begun, and none is to be begun here.
        """
        resetting = self._ended.copy()
        if resetting.any() and (self.autoreset_mode != AutoresetMode.NEXT_STEP or None in self._randoms):
            raise ResetNeeded("an episode has ended, or not begun: call reset() before step()")
        wanted = self.task.clipped(actions)
        self._tension = self.task.pulled(self._tension, wanted)
        self._cycle += 1
        lost = self._robots.step(self._tension) & ~resetting  # who are reset are stepped in vain
        self._see(~resetting)
        error = self.task.error(self._robots.tip, self._target()[0])
        reward = np.where(lost, LOST, self.task.reward(error, wanted))
        error[lost], reward[resetting] = np.nan, 0.0
        truncated = (self._cycle >= self.task.cycles) & ~lost & ~resetting
        self._ended = lost | truncated
        infos = _info(error, ~resetting)
        if self.autoreset_mode == AutoresetMode.SAME_STEP and self._ended.any():
            infos = self._final(self._observation(), error)
            self._begin_episodes(self._ended)
        elif resetting.any():
            self._begin_episodes(resetting)
            self._ended = lost | truncated
        return self._observation(), reward, lost, truncated, infos

    def close_extras(self, **kwargs: Any) -> None:
        """End the threads."""
        if self._pool is not None:
            self._pool.shutdown()

    def _final(self, observation: Array, error: Array) -> dict[str, Any]:
        """Return the information of a step after which ended episodes begin again."""
        ended, last = self._ended.copy(), np.full(self.num_envs, None, dtype=object)
        for index in np.flatnonzero(ended):
            last[index] = observation[index]
        found: dict[str, Any] = {"final_obs": last, "_final_obs": ended, "_final_info": ended}
        return found | {"final_info": _info(error, ended)} | _info(error, ~ended)

    def _begin_episodes(self, mask: Mask, goal: Any = None) -> None:
        lanes, drawn = np.flatnonzero(mask).tolist(), []
        for index in lanes:
            random = self._randoms[index]
            assert random is not None
            drawn.append(self.task.draw(random))
        self._robots.rest(lanes, [one.robot for one in drawn])
        if goal is None:
            for index, one in zip(lanes, drawn, strict=True):
                self._goal[index] = self._robots.goal(*one)
        else:
            self._goal[mask] = np.broadcast_to(np.asarray(goal, dtype=np.float64), self._goal.shape)[mask]
        self._tension[mask], self._cycle[mask], self._velocity[mask] = self.task.rest_tension, 0, 0.0
        self._begin[mask] = self._position[mask] = self._robots.tip[mask]
        self._ended = self._ended & ~mask
        self._see(mask)

    def _see(self, mask: Mask) -> None:
        """Take the poses that arrive from the cameras, once a step, and velocities by their differences."""
        seen = self._robots.tip.copy()
        arrived = mask.copy()
        for index in [] if self._robots.ideal else np.flatnonzero(mask).tolist():
            position = self._robots.see(index)
            arrived[index] = position is not None
            seen[index] = 0.0 if position is None else position
        moved = (seen - self._position) / self.task.period
        moving = (self._cycle > 0)[:, None]
        self._velocity[arrived] = np.where(moving, moved, 0.0)[arrived]
        self._position[arrived] = seen[arrived]

    def _target(self) -> tuple[Array, Array]:
        """Return targets [m] and their velocities [m/s] now, shape (N, 3) each."""
        return self.task.target(self._cycle, self._begin, self._goal)

    def _observation(self) -> Array:
        parts = (self._position, self._velocity, *self._target(), self._tension)
        return self.task.within(np.concatenate(parts, axis=1))


def _info(error: Array, mask: Mask) -> dict[str, Any]:
    """Return the errors of some, as Gymnasium does: nothing where there is none, else zeros for the others."""
    return {"error": np.where(mask, error, 0.0), "_error": mask} if mask.any() else {}
