"""One cycle of the real loop, controller and plant, as a map of its state, and the eigenvalues of its derivative.

The map is `cycle.step` with a step of the plant's rod; nothing is simplified. Its state is all that one cycle hands to
the next near a resting target: strains and rates of both rods, the model's rates a cycle before, the mean velocity of
its tip, the tension, the force on it, what the observer remembers, and poses on their way. It is differenced about the
equilibrium, which Newton's method finds with the same derivative (Astrom & Wittenmark, Computer-Controlled Systems,
1997, chapter 3: the loop is stable where all eigenvalues are within the unit circle).
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.drivers.simulator.rods import GeneralPlantRod, plant_rod
from tendond.model.estimation.observer import ObserverState, start_observer
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.state import StrainState
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs

Array = NDArray[np.float64]

DIFFERENCE = 1e-3
"""Difference of a state, of its scale. The map's curvature adds its square; steps are solved to a tolerance, and with
1e-6 that of fast modes, which it lets pass, looks like growth by 2 % a cycle."""

NEWTON = 6
"""Largest number of Newton's steps to the equilibrium."""

TENSION = 4
"""Number of the tension among the parts of the state."""

LONG_AGO = 10_000
"""Cycles since tracking began: the reference rests."""


@dataclass(frozen=True)
class Linear:
    """The loop about an equilibrium.

    Attributes:
        matrix: derivative of the map, shape (k, k). eigenvalues: of it, largest first, shape (k,).
        tension: at the equilibrium [N], shape (n,). missing: change of the state in a cycle there, of its scale [-].
    """

    matrix: Array
    eigenvalues: NDArray[np.complex128]
    tension: Array
    missing: float

    @property
    def radius(self) -> float:
        """Largest modulus of an eigenvalue [-]."""
        return float(np.abs(self.eigenvalues[0]))


class Loop:
    """Controller and plant at a resting target, both general rods; the observer of fixed gains.

    Args:
        config: configuration of the rig, whose reference rests.
        tension: of the tendons that hold the model at the target [N], shape (n,).
        delay: age of a pose that reaches the controller [cycles].
    """

    def __init__(self, config: RigConfig, tension: Array, delay: int) -> None:
        self.setup = CycleSetup.from_config(config)
        rod, plant = self.setup.rod, plant_rod(config.simulator, config.loop.period)
        if not isinstance(rod, GeneralRod) or not isinstance(plant, GeneralPlantRod):
            raise TypeError("both rods must be general ones")
        self.rod, self.plant, self.delay = rod, plant, delay
        at_rest = _static(rod, tension)
        self._start = _tracking(initial_state(self.setup), self.setup, at_rest, tension)
        behind = _static(plant, tension)
        poses = np.tile(behind.position, (delay, 1))
        self._parts = self._taken(self._start, behind, poses)
        self._sizes = [part.size for part in self._parts]
        self.state = np.concatenate([part.ravel() for part in self._parts])
        self.scale = np.repeat(self._scales(), self._sizes)

    @property
    def places(self) -> list[int]:
        """Where each part of the state begins, in the order of `_taken`."""
        return [0, *np.cumsum(self._sizes)[:-1].tolist()]

    def cycle(self, x: Array) -> Array:
        """Return the state a cycle later, shape (k,)."""
        state, behind, poses = self._made(x)
        queue = np.vstack([poses, behind.position])
        pose = TipPose(seq=LONG_AGO, stamp_ns=0, position=tuple(queue[0].tolist()), orientation=(1.0, 0.0, 0.0, 0.0))
        after, command, _ = step(self.setup, state, CycleInputs(pose=pose))
        moved = self.plant.step(behind, np.array(command.tension))
        return np.concatenate([part.ravel() for part in self._taken(after, moved, queue[1:])])

    def settle(self, cycles: int) -> None:
        """Run the loop, which redundant tendons need: their tensions go to an edge, where no derivative leads."""
        for _ in range(cycles):
            self.state = self.cycle(self.state)

    def linear(self) -> Linear:
        """Return the loop about its equilibrium, which is found from the state so far."""
        for _ in range(NEWTON):
            matrix = self._derivative(self.state)
            change = np.linalg.lstsq(np.eye(len(matrix)) - matrix, self.cycle(self.state) - self.state, rcond=1e-9)[0]
            self.state = self.state + change
            if np.max(np.abs(change) / self.scale) < 1e-7:
                break
        matrix = self._derivative(self.state)  # at the equilibrium itself: next to an edge it is another one
        values = np.linalg.eigvals(matrix).astype(np.complex128)
        missing = float(np.max(np.abs(self.cycle(self.state) - self.state) / self.scale))
        tension = np.split(self.state, np.cumsum(self._sizes)[:-1])[TENSION]
        return Linear(matrix, values[np.argsort(-np.abs(values))], tension, missing)

    def _derivative(self, x: Array) -> Array:
        columns = []
        for k, size in enumerate(DIFFERENCE * self.scale):
            aside = np.zeros(len(x))
            aside[k] = size
            columns.append((self.cycle(x + aside) - self.cycle(x - aside)) / (2.0 * size))
        return np.stack(columns, axis=1)

    def _taken(self, state: CycleState, behind: GeneralState, poses: Array) -> list[Array]:
        rod, observer = state.rod, state.observer
        assert isinstance(rod, GeneralState)
        assert isinstance(observer, ObserverState)
        earlier = rod.strain.rate if rod.strain.earlier is None else rod.strain.earlier[0]
        model = [rod.strain.strain, rod.strain.rate, earlier, rod.velocity, state.tension_estimate, rod.tip_force]
        plant = [behind.strain.strain, behind.strain.rate]
        return [*model, observer.past[1:], observer.mean, observer.force, *plant, poses]

    def _made(self, x: Array) -> tuple[CycleState, GeneralState, Array]:
        q, w, earlier, velocity, tension, force, past, mean, load, plant_q, plant_w, poses = np.split(
            x, np.cumsum(self._sizes)[:-1]
        )
        tension = np.maximum(tension, 0.0)  # differences at an edge go beyond it
        rod = _bent(self.rod, q, w, velocity, tension, force, earlier)
        before = self._start.observer
        assert isinstance(before, ObserverState)
        remembered = np.vstack([before.past[:1], past.reshape(-1, 3)])
        observer = replace(before, past=remembered, mean=mean, force=load, pull=force - load)
        state = replace(
            self._start,
            rod=rod,
            tip=self.rod.tip(rod),
            observer=observer,
            tension_estimate=tension,
            tension_command=tension,
            displacement_estimate=self.rod.displacements(rod),
            displacement_command=self.rod.displacements(rod),
        )
        return state, _bent(self.plant, plant_q, plant_w, np.zeros(3), tension, np.zeros(3)), poses.reshape(-1, 3)

    def _scales(self) -> list[float]:
        """Scale of each part of the state: a radian of bend, in the first mode's time, and what holds it."""
        one = self.rod.parameters
        bend, rate = 1.0 / one.length, self.rod.strain_rod.frequencies(self.rod.strain_rod.rest(), self.rod.loads(None))
        omega = float(2.0 * np.pi * rate[0])
        tension, force = one.tension_scale, one.bending_stiffness / one.length**2
        length = one.length
        rates = bend * omega
        return [bend, rates, rates, length * omega, tension, force, length, length, force, bend, rates, length]


def _static(rod: GeneralRod, tension: Array) -> GeneralState:
    state = rod.solve_static(np.zeros(len(tension)))
    for part in np.linspace(0.0, 1.0, 9)[1:]:
        state = rod.solve_static(part * tension, start=state)
    return state


def _bent(
    rod: Any, q: Array, w: Array, velocity: Array, tension: Array, force: Array, earlier: Array | None = None
) -> GeneralState:
    strain = StrainState(q.copy(), w.copy(), earlier=None if earlier is None else (earlier.copy(), earlier.copy()))
    return GeneralState(strain, tension.copy(), force.copy(), rod.strain_rod.tip(strain)[0], velocity.copy())


def _tracking(state: CycleState, setup: CycleSetup, rod: GeneralState, tension: Array) -> CycleState:
    """Return the state of a controller that has long rested at its target."""
    tip = setup.rod.tip(rod)
    return replace(
        state,
        tick=LONG_AGO,
        mode=Mode.TRACKING,
        mode_since=0,
        rod=rod,
        tip=tip,
        observer=start_observer(setup.observer, tip.position),
        tension_estimate=tension,
        tension_command=tension,
        commissioned=True,
    )
