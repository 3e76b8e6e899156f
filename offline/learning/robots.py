"""Simulated robots that are stepped together: the plant of `tendond simulate` as far as a batch of rods carries it.

That is: the general rod, friction of tendons, lag of servos, the camera, and pushes on the tip. Each robot moves to
the last bit as `drivers/simulator/plant.py:Plant` moves it. A weight, pushes beside the tip, the shooting rod and
MuJoCo are not carried: what is in a batch has the loads that `RodBatch.step` takes.
"""

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.faults import Faults
from tendond.drivers.simulator.loads import impacts_at
from tendond.drivers.simulator.mocap import Mocap
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import GeneralPlantRod, plant_robot
from tendond.drivers.simulator.servo import SimulatedActuators
from tendond.model.errors import ConvergenceError
from tendond.model.rod.tip import Tip
from tendond.model.strain.batch import RodBatch
from tendond.model.strain.state import StrainState
from tendond.offline.learning.environment import pulling
from tendond.offline.learning.episode import REST_SECONDS, Task
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.config.simulator import SimulatedMocap

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Run = Callable[[Callable[[int], None], Iterable[int]], Iterable[None]]


def batched(config: RigConfig) -> RigConfig:
    """Return the rig with the general rod as its plant, which a batch steps.

    Raises:
        ConfigError: the plant has what a batch does not carry.
    """
    section, instead = config.simulator, "use TendonEnv in gymnasium.vector.SyncVectorEnv"
    if section.solver in ("shooting", "mujoco"):
        raise ConfigError(f"simulator.solver = '{section.solver}': must be 'general' for many at once: or {instead}")
    if section.weight.mass > 0.0:
        raise ConfigError(f"simulator.weight: many at once carry none: set mass to 0, or {instead}")
    if any(one.place != 1.0 for one in section.impacts):
        raise ConfigError(f"simulator.impacts: must be at the tip, place = 1, for many at once: or {instead}")
    return config.model_copy(update={"simulator": section.model_copy(update={"solver": "general"})})


class Robots:
    """Simulated robots, N of them, in lanes; each lane has one of the robots that a task numbers.

    Args:
        task: whose rig `batched` returned. lanes: their number, N. workers: parts that `run` takes. run: see
            `RodBatch.step`.

    Attributes:
        tip: true positions [m], shape (N, 3).
    """

    def __init__(
        self,
        task: Task,
        lanes: int,
        workers: int,
        run: Callable[[Callable[[int], None], Iterable[int]], Iterable[None]],
    ) -> None:
        self._task, self._workers, self._run = task, workers, run
        self._numbers = [0] * lanes
        self._rods: dict[int, GeneralPlantRod] = {}
        self._rests: dict[int, tuple[StrainState, Array, Array]] = {}
        section = task.config.simulator
        self._impacts, self._ideal = section.impacts, section.mocap == SimulatedMocap()
        self._cameras = [self._camera(0) for _ in range(lanes)]
        self._servos = SimulatedActuators(section.servo, task.period, np.zeros(lanes * task.tendons))
        self._rubbing = np.array([one.friction > 0.0 for one in plant_robot(section).tendons])
        self._rest_steps = round(REST_SECONDS / task.period)
        self._steps = np.full(lanes, self._rest_steps)
        self.tip = np.zeros((lanes, 3))
        self._batch = self._laid_out()

    def rest(self, lanes: Iterable[int], numbers: Iterable[int]) -> None:
        """Put some lanes at rest under the pretension, each with the robot of a number."""
        placed = dict(zip(lanes, numbers, strict=True))
        kept = {lane: self._batch.state(lane) for lane in range(len(self._numbers)) if lane not in placed}
        if any(self._numbers[lane] != number for lane, number in placed.items()):
            for lane, number in placed.items():
                self._numbers[lane] = number
            self._batch = self._laid_out()
            for lane, state in kept.items():
                self._batch.set_state(lane, state)
        ends = self._servos.ends.reshape(len(self._numbers), -1)
        for lane, number in placed.items():
            state, ends[lane], self.tip[lane] = self._at_rest(number)
            self._batch.set_state(lane, state)
            self._cameras[lane] = self._camera(number)
            self._steps[lane] = self._rest_steps
            self.see(lane)  # as it stands there before the episode
        self._servos.stand(ends.reshape(-1))

    def goal(self, number: int, tensions: Array) -> Array:
        """Return where the tip of a robot rests under tensions [N], shape (n,): [m], shape (3,).

        Raises:
            ConvergenceError: it does not.
        """
        rod = self._rod(number)
        return rod.tip(rod.solve_static(tensions)).position

    def step(self, tension: Array) -> Mask:
        """Advance all by a period under tensions [N], shape (N, n); return which have no solution, shape (N,).

        These are put to rest, but for their tips, which stay where they were.
        """
        middle, end = (one.reshape(tension.shape) for one in self._servos.follow_tension(tension.reshape(-1)))
        held = np.where(self._rubbing, end, middle)
        force = np.zeros((len(tension), 3))
        for lane in range(len(tension) if self._impacts else 0):
            for _, push in impacts_at(self._impacts, float(self._steps[lane] * self._task.period)):
                force[lane] += push
        self._steps += 1
        lost: Mask = np.zeros(len(tension), dtype=np.bool_)
        try:
            self.tip = self._batch.follow(tension=held, tip_force=force, run=self._run).tip[0]
        except ConvergenceError:  # of one is said of all
            lost = np.asarray(~np.isfinite(np.hstack((self._batch.strain, self._batch.rate))).all(axis=1))
            for lane, number in enumerate(self._numbers):
                if lost[lane]:
                    self._batch.set_state(lane, self._at_rest(number)[0])
                else:
                    self.tip[lane] = self._rod(number).strain_rod.tip(self._batch.state(lane))[0]
        return lost

    def see(self, lane: int) -> Array | None:
        """Return the position that arrives from the camera of a lane [m], shape (3,), if any. Call it once a step."""
        if self._ideal:
            return np.array(self.tip[lane])
        nothing = np.zeros(3)
        tip = Tip(self.tip[lane], np.eye(3), nothing, nothing, np.zeros((3, 0)), nothing)
        pose = self._cameras[lane].see(tip, float(self._steps[lane] * self._task.period), 0)
        return None if pose is None or not pose.valid else np.array(pose.position)

    @property
    def ideal(self) -> bool:
        """Whether the cameras see the tips as they are, at once and always."""
        return self._ideal

    def _laid_out(self) -> RodBatch:
        return RodBatch([self._rod(one).robot for one in self._numbers], self._task.period, self._workers)

    def _rod(self, number: int) -> GeneralPlantRod:
        if number not in self._rods:
            self._rods[number] = GeneralPlantRod(plant_robot(self._task.rig(number).simulator), self._task.period)
        return self._rods[number]

    def _camera(self, number: int) -> Mocap:
        section = self._task.rig(number).simulator
        return Mocap(section.mocap, section.seed, Faults(self._task.tendons))

    def _at_rest(self, number: int) -> tuple[StrainState, Array, Array]:
        """Return the state of a robot at rest, its servos' tensions [N], shape (n,), and its tip [m], shape (3,)."""
        if number not in self._rests:
            rod = self._rod(number)
            plant = Plant(self._task.rig(number), rod)
            for _ in range(self._rest_steps):
                plant.step(pulling(plant.seq, self._task.rest_tension))
            ends = np.array(plant.observe(0)[1].tension)
            self._rests[number] = plant.state.strain, ends, rod.tip(plant.state).position
        return self._rests[number]
