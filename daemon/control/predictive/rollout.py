"""The model along the horizon: the general rod's own steps under a plan, and their derivatives by the plan.

    x(k+1) = F(x(k), u(k)),    S(k+1) = A(k) S(k) + B(k) E(k),    p(k) = p(x(k)),  dp(k) = C(k) S(k)

with x = (q, w), E(k) the shares of the plan's knots in the tensions of step k. F, A, B, C are exact for the discrete
rod (`strain.derivatives.linearise`); loads that the observer has found are held.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.predictive.horizon import Horizon
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.estimation.observer import ObserverState
from tendond.model.numerics.compile import Bound
from tendond.model.rods.backbone import interpolated
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.kinematics import Shape, empty_shape, find_shape
from tendond.model.strain.tendons import Paths, empty_paths, find_paths

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rollout:
    """The robot along the horizon under a plan; world frame; N steps, B knots, m tendons, p points of the body.

    Attributes:
        position: of the tip [m], shape (N, 3); by_plan: its derivatives [m/N], shape (N, 3, B m).
        direction: of the tip [-], shape (N, 3); direction_by_plan: [1/N], shape (N, 3, B m).
        side: first axis of the tip's frame [-], shape (N, 3); side_by_plan: [1/N], shape (N, 3, B m).
        displacement: of the tendons [m], shape (N, m); displacement_by_plan: [m/N], shape (N, m, B m).
        strain: of the modes, shape (N, n); strain_by_plan: shape (N, n, B m).
        points: of the body [m], shape (N, p, 3); points_by_plan: [m/N], shape (N, p, 3, B m); points_now: (p, 3).
    """

    position: Array
    by_plan: Array
    direction: Array
    direction_by_plan: Array
    side: Array
    side_by_plan: Array
    displacement: Array
    displacement_by_plan: Array
    strain: Array
    strain_by_plan: Array
    points: Array
    points_by_plan: Array
    points_now: Array


class Predictor:
    """The model of one robot along one horizon. Not for use by two threads at once: scratch memory.

    Args:
        rod: the controller's model, or one like it; its time step is the cycle's.
        horizon: steps and knots.
        at: arc lengths of points of the body that are wanted as well [m], shape (p,).
        elastic: tendons stretch.

    Attributes:
        horizon: as given. tendons: number of them.
    """

    def __init__(self, rod: GeneralRod, horizon: Horizon, at: Array | None = None, *, elastic: bool = False) -> None:
        self.horizon, self.tendons = horizon, len(rod.robot.tendons)
        steps, n = horizon.steps, rod.strain_rod.modes
        self._models = {
            cycles: _Model(rod if cycles == 1 else GeneralRod(rod.robot, cycles * horizon.period, rod.compliance))
            for cycles in set(horizon.cycles)
        }
        self._weights = rod.backbone.weights(np.zeros(0) if at is None else at)
        self._stretch = np.diag(1.0 / rod.tendon_stiffness) if elastic else np.zeros((self.tendons, self.tendons))
        self._sensitivity = np.zeros((steps + 1, 2 * n, horizon.knots * self.tendons))
        self._rows = np.zeros((steps, 9 + self.tendons + 3 * len(self._weights[0]), n))

    def roll(self, state: GeneralState, observer: ObserverState | EstimatorState, plan: Array) -> Rollout:
        """Run the model along the horizon.

        Args:
            state: the model's now. observer: what is known of loads and errors, which are held.
            plan: tensions at the knots [N], shape (B, m).

        Raises:
            ConvergenceError: not a finite state.
        """
        horizon, m, p = self.horizon, self.tendons, len(self._weights[0])
        steps, columns = horizon.steps, horizon.knots * m
        tensions = horizon.shares @ plan
        (places, directions, sides), points = np.empty((3, steps, 3)), np.empty((steps, p, 3))
        displacements = np.empty((steps, m))
        strains = np.empty((steps, self._rows.shape[2]))
        before, rows = state.strain, self._rows
        now = interpolated(self._weights, self._models[1].look(before.strain)[0]) if p > 0 else np.zeros((0, 3))
        for k, (cycles, wanted) in enumerate(zip(horizon.cycles, tensions, strict=True)):
            model = self._models[cycles]
            acting = observer.acting(wanted) if isinstance(observer, EstimatorState) else wanted
            force = observer.tip_force if k == 0 else observer.force  # the observer's pull is of this cycle
            model.rod.use(state)
            step = model.linear.step(before, model.rod.loads(acting, force, state.body))
            after = self._sensitivity[k + 1]
            np.matmul(step.a, self._sensitivity[k], out=after)
            after += (horizon.shares[k][:, None] * step.b[:, None, :]).reshape(-1, columns)
            before = step.state
            shape, paths = model.look(before.strain)
            strains[k], displacements[k] = before.strain, paths.displacement + self._stretch @ wanted
            places[k], directions[k] = shape.position[-1], shape.rotation[-1, 2::3]
            sides[k] = shape.rotation[-1, ::3]
            _write_point(rows[k, 3:9], shape.twist[-1], places[k], sides[k])
            _write_point(rows[k, :6], shape.twist[-1], places[k], directions[k])
            rows[k, 9 : 9 + m] = paths.gradient
            if p > 0:
                points[k] = interpolated(self._weights, shape)
                self._write_body(rows[k, 9 + m :], shape)
        strain_by_plan = self._sensitivity[1:, : rows.shape[2]].copy()
        by_plan = rows @ strain_by_plan
        by_plan[:, 9 : 9 + m] += np.einsum("kb,ij->kibj", horizon.shares, self._stretch).reshape(steps, m, columns)
        return Rollout(
            places, by_plan[:, :3], directions, by_plan[:, 3:6], sides, by_plan[:, 6:9],
            displacements, by_plan[:, 9 : 9 + m],
            strains, strain_by_plan, points, by_plan[:, 9 + m :].reshape(steps, p, 3, columns), now,
        )  # fmt: skip

    def _write_body(self, rows: Array, shape: Shape) -> None:
        """Write the derivatives of the body's points by the strains, shape (3 p, n): of the cubics between nodes."""
        nodes = np.empty((len(shape.position), 6, rows.shape[1]))
        for node, twist, place, turned in zip(nodes, shape.twist, shape.position, shape.rotation, strict=True):
            _write_point(node, twist, place, turned[2::3])
        by_place, by_tangent = (
            np.tensordot(one, part, 1) for one, part in zip(self._weights, (nodes[:, :3], nodes[:, 3:]), strict=True)
        )
        rows[:] = (by_place + by_tangent).reshape(rows.shape)


class _Model:
    """A rod of one time step, its linear model, and room for what it looks like."""

    def __init__(self, rod: GeneralRod) -> None:
        layout = rod.strain_rod.layout
        self.rod, self.linear = rod, Linearisation(rod.strain_rod)
        self._shape, self._paths = empty_shape(layout), empty_paths(layout)
        self._find_shape, self._find_paths = Bound(find_shape), Bound(find_paths)

    def look(self, strain: Array) -> tuple[Shape, Paths]:
        """Return shape and tendon paths at strains; the next call overwrites them."""
        layout = self.rod.strain_rod.layout
        self._find_shape.call(layout, strain, self._shape)
        self._find_paths.call(layout, strain, self._paths)
        return self._shape, self._paths


def _write_point(rows: Array, twist: Array, place: Array, direction: Array) -> None:
    """Write the derivatives of a point's position and of a direction by the strains, shape (6, n), by its twist."""
    (x, y, z), (a, b, c), count = place.tolist(), direction.tolist(), rows.shape[1]
    turn, move = twist[:3, :count], twist[3:, :count]
    rows[0] = move[0] + z * turn[1] - y * turn[2]
    rows[1] = move[1] + x * turn[2] - z * turn[0]
    rows[2] = move[2] + y * turn[0] - x * turn[1]
    rows[3] = c * turn[1] - b * turn[2]
    rows[4] = a * turn[2] - c * turn[0]
    rows[5] = b * turn[0] - a * turn[1]
