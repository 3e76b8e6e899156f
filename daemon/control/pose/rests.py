"""Equilibria of a robot of sections under its tendons' tensions, and the one whose tip is nearest to a pose."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.allocation import allocate
from tendond.daemon.control.pose.pose import RADIAN, Aim, Miss, Pose, counted, difference, miss
from tendond.model.errors import ParameterError
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.rods.interface import ModelRod
from tendond.model.rods.stations import BodyLoads
from tendond.model.strain.derivatives.linearise import Linearisation

Array = NDArray[np.float64]

Posture = Literal["least_tension", "mid_range"]
"""Use of redundant tendons: the least tension, or the middle of the range of tensions, far from both limits."""

STEPS = 60
"""Largest number of steps of a search."""

CLOSE = 1e-6
"""Motion of the tip below which a step ends a search, of the backbone's length."""

RELAX = 0.1
"""Part of the way to the preferred tensions that redundant tendons go from one pose of a path to the next. Where the
least tension changes from one shape to another, the robot passes from one to the other in some tens of poses instead
of jumping. Chosen: with 1, two sections on a circle of 0.1 m jump six times a turn, and swing 30 mm."""

STRETCH = 0.15
"""Largest step of the tip in a search, of the backbone's length: further, the linear model of a bend is a wrong one."""


@dataclass(frozen=True)
class PoseRest:
    """An equilibrium.

    Attributes:
        tension: [N], shape (n,).
        state: of the rod.
        pose: of the tip.
        jacobian: derivative of position [m] and rotation vector [rad] of the tip by the tensions, shape (6, n).
        displacement_jacobian: derivative of the tendons' displacements by the tensions [m/N], shape (n, n).
    """

    tension: Array
    state: GeneralState
    pose: Pose
    jacobian: Array
    displacement_jacobian: Array


class PoseRests:
    """Equilibria of a rod under its own weight, and under tensions within bounds. Not for two threads: scratch memory.

    Args:
        rod: the controller's model.
        tension_min, tension_max: bounds of every tension [N].
        posture: use of redundant tendons.

    Attributes:
        rod, tension_min, tension_max: as given.
        radian: distance that counts as much as 1 rad [m].
        preferred: tensions to which redundant tendons tend [N], shape (n,).

    Raises:
        ParameterError: the rod is the shooting rod, which has no sections.
    """

    def __init__(self, rod: ModelRod, tension_min: float, tension_max: float, posture: Posture) -> None:
        if not isinstance(rod, GeneralRod):
            raise ParameterError("poses need the general rod: set control.solver = 'general'")
        self.rod, self.tension_min, self.tension_max = rod, tension_min, tension_max
        self.radian = RADIAN * rod.robot.length
        wanted = tension_min if posture == "least_tension" else 0.5 * (tension_min + tension_max)
        self.preferred: Array = np.full(len(rod.robot.tendons), wanted)
        self.linear = Linearisation(rod.strain_rod)

    def rest(
        self,
        tension: Array,
        start: GeneralState | None = None,
        tip_force: Array | None = None,
        body: BodyLoads | None = None,
    ) -> PoseRest:
        """Solve the equilibrium under tensions [N], shape (n,), a force on the tip [N], shape (3,), and body loads.

        Raises:
            ConvergenceError: there is none, or none with derivatives.
        """
        rod, force = self.rod, np.zeros(3) if tip_force is None else tip_force
        state = rod.solve_static(tension, tip_force=force, start=start, body=body)
        rod.use(state)
        found = self.linear.rest(state.strain, rod.loads(tension, force, body))
        pulled = self.linear.outputs(state.strain).displacement[:, : rod.strain_rod.modes] @ found.strain
        jacobian = np.vstack((found.position, found.rotation))
        return PoseRest(tension, state, self.pose(state), jacobian, pulled)

    def pose(self, state: GeneralState) -> Pose:
        """Return the tip's pose in a state."""
        return Pose(*self.rod.strain_rod.tip(state.strain))

    def find(self, wanted: Pose, aim: Aim, start: PoseRest, relax: float = 1.0) -> tuple[PoseRest, Miss]:
        """Find the equilibrium whose tip is nearest to a pose, in the measure of `pose.difference`, and the distance.

        Gauss-Newton steps from a neighbouring equilibrium, halved where they do not lead nearer, within the bounds.

        Args:
            wanted: the pose. aim: what of it counts. start: the neighbouring equilibrium.
            relax: part of the way from its tensions to the preferred ones that redundant tendons go.

        Raises:
            ConvergenceError: the search leaves the rod's equilibria.
        """
        rest, length = start, self.rod.robot.length
        preferred = start.tension + relax * (self.preferred - start.tension)
        apart, part = self._apart(rest, wanted, aim), 1.0
        for _ in range(STEPS):
            step = part * self._step(rest, wanted, aim, preferred)
            moved = float(np.max(np.abs(counted(rest.jacobian, rest.pose, aim, self.radian) @ step)))
            settled = float(np.max(np.abs(step))) < 1e-4 * self.tension_max
            if moved < CLOSE * length and settled:
                break
            trial = self.rest(rest.tension + step, rest.state)
            there = self._apart(trial, wanted, aim)
            if there < apart + CLOSE * length:
                rest, apart, part = trial, there, min(1.0, 2.0 * part)
            elif part < 1e-3:
                break
            else:
                part *= 0.5
        return rest, miss(rest.pose, wanted, aim)

    def _step(self, rest: PoseRest, wanted: Pose, aim: Aim, preferred: Array) -> Array:
        """Return the change of the tensions towards a pose [N], shape (n,), with the tip moved by `STRETCH` or less."""
        asked = difference(rest.pose, wanted, aim, self.radian)
        asked = asked * min(1.0, STRETCH * self.rod.robot.length / max(float(np.linalg.norm(asked)), 1e-12))
        jacobian = counted(rest.jacobian, rest.pose, aim, self.radian)
        low, high = self.tension_min - rest.tension, self.tension_max - rest.tension
        return allocate(jacobian, asked, rest.tension, preferred, np.minimum(low, 0.0), np.maximum(high, 0.0))

    def _apart(self, rest: PoseRest, wanted: Pose, aim: Aim) -> float:
        return float(np.linalg.norm(difference(rest.pose, wanted, aim, self.radian)))
