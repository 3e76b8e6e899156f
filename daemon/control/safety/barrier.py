"""The safety filter: the command nearest to the one wanted whose motion, if it is held, keeps all constraints.

A constraint h (a distance less its margins) must hold along the whole motion that follows if the command is held from
now on. With H = min h over the motion under the tensions applied now, a command is allowed if

    min h over its own motion >= (1 - gamma) H,    gamma = 1 - exp(-period / approach_time)

with the motion of a linear model, and of the model itself for the command that is held, and again for the one found.
That is the discrete-time barrier condition (Agrawal & Sreenath, Discrete control barrier functions, RSS 2017) with the
held command as backup (Gurriet et al., A scalable safety critical control framework, IEEE Access 8, 2020): to hold is
always allowed while H >= 0, so the condition can be met again in the next cycle. Where H < 0, because model or
constraint were wrong, it asks for a return. See docs/explanation/safety-filter.md.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.safety.body import Body, Shape
from tendond.daemon.control.safety.constraints import ALONE, Constraints, Moved, Values
from tendond.daemon.control.safety.course import Course
from tendond.daemon.control.safety.horizon import Horizon
from tendond.model.errors import ConvergenceError
from tendond.model.numerics.compile import Bound
from tendond.model.numerics.nearest import ROUNDS, nearest_allowed
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.model.strain.derivatives.linearise import Linearisation
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.scratch import Loads

Array = NDArray[np.float64]

ENOUGH = 1e-5
"""Shortfall of a constraint that counts as none [m], and for strains a thousandth of it: below any margin."""

AIM = 0.1
"""Part of `ENOUGH` by which a program goes beyond its rows, so that rounding does not bring a further round."""

NEARLY = 20.0
"""Shortfall that still counts as kept after the last round, of `ENOUGH`: 0.2 mm, beside margins of millimetres."""

FAR = 3.0
"""Distance, of the linear model's motion, from which on that one is believed: it is not wrong by twice itself."""

PARTS = (1.0, 0.5, 0.25)
"""Parts of a change that are tried where the whole does not keep the constraints on the model's own motion."""


Along = Callable[[Array], Values]
Bounds = tuple[Array, Array]


class Filtered(NamedTuple):
    """The filter's result.

    Attributes:
        command: [N], shape (m,). constraint: name of the one that is nearest to its limit, after the filter.
        distance: of it along the motion that follows, less margins, [m], of strain [-].
        kept: whether all constraints are, within `NEARLY`; met: within `ENOUGH`.
    """

    command: Array
    constraint: str
    distance: float
    kept: bool
    met: bool


class Barrier:
    """The filter of a configuration. Not for use by two threads at once.

    Args:
        rod: the model. body: its places. constraints: of them. horizon: times of the motion. gamma: see above [-].
    """

    def __init__(self, rod: GeneralRod, body: Body, constraints: Constraints, horizon: Horizon, gamma: float) -> None:
        self.body, self.constraints, self.horizon, self.gamma = body, constraints, horizon, gamma
        self._rod, self._linear, self._course = rod, Linearisation(rod.strain_rod), Course(rod, body, horizon)
        self._bends = np.ascontiguousarray(body.bend_rows.reshape(-1, rod.strain_rod.modes)[: 2 * constraints.bends])
        self._allowed = Bound(nearest_allowed)
        self._enough = np.full(len(constraints.names), ENOUGH)
        self._enough[constraints.surfaces.count :] *= 1e-3

    def warm_up(self, rest: GeneralState) -> None:
        """Run every kernel once, at a resting state: most are needed only near a constraint, in the middle of a run."""
        tensions = np.zeros_like(rest.tensions)
        shape, low = self.body.shape(rest.strain), tensions - 1.0
        moved, _ = self._linear_motion(rest.strain, self._rod.loads(tensions), shape)
        held = self._moved(shape, *self._course.follow(rest, tensions, tensions, np.zeros(3)))
        for motion, weights in ((moved, np.ones(1 + len(tensions))), (held, ALONE)):
            values = self.constraints.values(shape.points, shape.bends, motion, weights)
        slopes = self.constraints.slopes(self.constraints.values(shape.points, shape.bends, held), moved[0], moved[1])
        self._allowed.call(slopes, values.clear, tensions, tensions, low, tensions)

    def at_rest(self, state: StrainState) -> tuple[str, float]:
        """Return the nearest constraint of a resting state, and its distance less margins [m], of strain [-]."""
        shape = self.body.shape(state)
        clear = self._now(shape.points, shape)
        row = int(np.argmin(clear / self._enough))
        return self.constraints.names[row], float(clear[row])

    def at_tip(self, place: Array) -> tuple[str, float]:
        """Return the nearest surface of a place of the tip [m], shape (3,), and its distance less margins [m]."""
        surfaces, last = self.constraints.surfaces, len(self.body.parts) - 1
        of_tip = np.flatnonzero(surfaces.point == last)
        if len(of_tip) == 0:
            return "", np.inf
        clear = surfaces.measure(np.broadcast_to(place, (last + 1, 3))).values[of_tip] - self.constraints.margin
        row = int(np.argmin(clear))
        return self.constraints.names[of_tip[row]], float(clear[row])

    def _now(self, points: Array, shape: Shape) -> Array:
        """Return the constraints of a shape that does not move, shape (r,)."""
        still = np.zeros((1, len(points), 3, 1)), np.zeros((1, self.constraints.bends, 2, 1))
        return np.asarray(self.constraints.values(points, shape.bends, still).clear[0])

    def filter(
        self, state: GeneralState, tensions: Array, force: Array, shift: Array, wanted: Array, low: Array, high: Array,
        acting: Callable[[Array], Array] = lambda tensions: tensions,
    ) -> Filtered:  # fmt: skip
        """Return the allowed command nearest to the one wanted.

        Args:
            state: of the model. tensions: commands in effect now [N], shape (m,). force: on its tip [N], shape (3,).
            shift: of the tip, by which the observer corrects the model's [m], shape (3,).
            wanted: command [N], shape (m,), within low and high: bounds of the command by all other limits [N].
            acting: tensions on the robot under a command, with their estimated errors [N].

        Raises:
            ConvergenceError: the model has no step from here, or no finite motion after it.
            LinAlgError: the program is singular.
        """
        shape = self.body.shape(state.strain)
        points = shape.points + (self.body.parts**2)[:, None] * shift
        now, change = self._now(points, shape), wanted - tensions
        weights = np.ones(1 + len(change))

        def linear(moved: Moved, change: Array) -> Values:
            weights[1:] = change
            return self.constraints.values(points, shape.bends, moved, weights)

        def followed(command: Array) -> Moved:
            return self._moved(shape, *self._course.follow(state, acting(tensions), acting(command), force))

        def floor_of(held: Array) -> Array:
            return np.asarray((1.0 - self.gamma) * np.minimum(held.min(axis=0), now))

        self._rod.use(state)
        loads = self._rod.loads(acting(tensions), force, state.body)
        moved, sane = self._linear_motion(state.strain, loads, shape)
        if sane:
            still, driven = linear(moved, np.zeros_like(change)), linear(moved, change)
            if self._far(now, still, driven) and not (floor_of(still.clear) - driven.clear > self._enough).any():
                return self._described(wanted, driven.clear, True)
        held = followed(tensions)
        if not sane or np.max(np.abs(moved[0][..., :1] - held[0])) > self._rod.robot.length:
            # Fast modes that ring make the step's derivatives unstable, far ahead: then those without a motion.
            at_rest = replace(state.strain, rate=np.zeros_like(state.strain.rate), earlier=None)
            self._rod.use(state)
            moved, finite = self._linear_motion(at_rest, loads, shape)
            if not finite:
                raise ConvergenceError("safety: the motion ahead is not finite", 0.0, 0.0, 0)
        moved[0][..., :1], moved[1][..., :1] = held
        floor = floor_of(linear(moved, np.zeros_like(change)).clear)
        found = self._tried(wanted, floor, followed, points, shape)
        if found[0] >= -1.0:
            return self._described(wanted, found[2], True)
        hold, command = np.clip(tensions, low, high), wanted
        for bounds in ((np.minimum(hold, wanted), np.maximum(hold, wanted)), (low, high)):
            nearest = self._nearest(lambda one: linear(moved, one), floor, moved, tensions, wanted, hold, bounds)
            command = nearest.command
            if nearest.met:
                break
        tried = []
        for part in (*PARTS, 0.0):
            tried.append(self._tried(hold + part * (command - hold), floor, followed, points, shape))
            if tried[-1][0] >= -NEARLY:
                break
        spare, command, clear = tried[-1] if tried[-1][0] >= -NEARLY else max(tried, key=lambda one: one[0])
        return self._described(command, clear, spare >= -NEARLY)

    def _linear_motion(self, strain: StrainState, loads: Loads, shape: Shape) -> tuple[Moved, bool]:
        """Return moves of the points [m], (k, p, 3, 1 + m), and changes of the bends, and whether these are finite."""
        step = self._linear.step(strain, loads)
        before, (p, _, n), bends = np.concatenate((strain.strain, strain.rate)), shape.jacobians.shape, self._bends
        moves, turns, finite = self.horizon.motion(before, step, shape.jacobians.reshape(-1, n), bends)
        count, columns = len(moves), moves.shape[-1]
        moved = moves.reshape(count, p, 3, columns), turns.reshape(count, self.constraints.bends, 2, columns)
        return moved, finite

    def _tried(
        self, command: Array, floor: Array, followed: Callable[[Array], Moved], points: Array, shape: Shape
    ) -> tuple[float, Array, Array]:
        """Return what the model's own motion under a command spares, in `ENOUGH`, the command, and its constraints."""
        clear = self.constraints.values(points, shape.bends, followed(command)).clear
        return float(np.min((clear - floor) / self._enough)), command, clear

    def _moved(self, shape: Shape, strains: Array, points: Array) -> Moved:
        """Return moves of the points [m], (k, p, 3), and changes of the bends [-], (k, b, 2), along a motion."""
        turns = np.einsum("bin,kn->kbi", self.body.bend_rows[: self.constraints.bends], strains)
        return (points - shape.points)[..., None], (turns - shape.bends[: self.constraints.bends])[..., None]

    def _far(self, now: Array, held: Values, commanded: Values) -> bool:
        """Tell whether all constraints, as they are `now`, are far beside the motion to come, held and commanded."""
        return bool((now > FAR * np.maximum(held.reach, commanded.reach)).all())

    def _nearest(
        self, along: Along, floor: Array, moved: Moved, tensions: Array, wanted: Array, hold: Array, bounds: Bounds
    ) -> Filtered:
        """Search the allowed command; `along` gives the constraints for a change of the tensions applied now.

        The constraints are linearised where the command is held, not where it is wanted, which may be behind an
        obstacle. The distance to a sphere or a plane is convex: what its linearisation allows is allowed.
        """
        command = hold
        for _ in range(ROUNDS):
            values = along(command - tensions)
            lack = floor - values.clear
            if command is not hold and not (lack > self._enough).any():
                return self._described(command, values.clear, True)
            slopes = self.constraints.slopes(values, *moved)
            command = self._allowed.call(slopes, lack + AIM * self._enough, command, wanted, *bounds)
        return self._less_bad(along, floor, command, hold, tensions)

    def _less_bad(self, along: Along, floor: Array, command: Array, hold: Array, tensions: Array) -> Filtered:
        """Return the command, or to hold where that is nearer to the constraints, which neither may keep."""
        clear = [along(one - tensions).clear for one in (command, hold)]
        spare = [float(np.min((one - floor) / self._enough)) for one in clear]
        better = 0 if spare[0] >= -NEARLY or spare[0] >= spare[1] else 1
        found = self._described((command, hold)[better], clear[better], spare[better] >= -NEARLY)
        return found._replace(met=spare[better] >= -1.0)

    def _described(self, command: Array, clear: Array, kept: bool) -> Filtered:
        least = clear.min(axis=0)
        row = int(np.argmin(least / self._enough))
        return Filtered(command, self.constraints.names[row], float(least[row]), kept, kept)
