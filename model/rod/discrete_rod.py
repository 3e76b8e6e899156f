"""A rod with its scheme in space, its time step and its scratch memory, ready to be solved; and its loads."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.errors import ParameterError
from tendond.model.rod.discretisation import bdf_alpha, discretise, gravity_loads
from tendond.model.rod.loads import ZERO, pack_loads, push_shape
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.prediction import PredictionScratch
from tendond.model.rod.state import RodState
from tendond.model.rod.tip_body import TipBody
from tendond.model.solver.problem import HISTORY, Profile
from tendond.model.solver.schemes import DEFAULT, Scheme, scheme
from tendond.model.solver.work import LANES, new_work

Array = NDArray[np.float64]


class DiscreteRod:
    """A rod with its discretisation in space and time, and the bodies and loads on it; arguments as those of `Rod`."""

    def __init__(
        self,
        parameters: RodParameters,
        space: str | Scheme = DEFAULT,
        nodes: int | None = None,
        time_step: float = 0.01,
        alpha: float = -0.2,
        tolerance: float | None = None,
    ) -> None:
        self.parameters = parameters
        self.scheme = scheme(space) if isinstance(space, str) else space
        self.nodes = self.scheme.nodes if nodes is None else nodes
        self.time_step = time_step
        self._data = discretise(parameters, self.scheme, self.nodes, tolerance)
        self._bdf = bdf_alpha(time_step, alpha)
        n, self._stages = parameters.tendon_count, len(self._data.push)
        self._work = new_work(self._data, parameters.force_scale)
        self._no_history = np.zeros((self._stages, HISTORY))
        self._loads = np.zeros(n + 15)
        self._weight = gravity_loads(parameters)
        self._predicted_loads = self._weight.copy()
        self._scratch = PredictionScratch(np.empty((self._stages, HISTORY)), self._new_profile(), np.zeros((6, LANES)))

    def loads(
        self,
        actuation: ArrayLike,
        tip_force: ArrayLike = ZERO,
        tip_moment: ArrayLike = ZERO,
        distributed_force: ArrayLike = ZERO,
        distributed_moment: ArrayLike = ZERO,
        push: ArrayLike = ZERO,
    ) -> Array:
        """Pack loads as `advance` takes them, with gravity, shape (n + 15,).

        Raises:
            ParameterError: loads of the wrong shape or not finite.
        """
        parts = (actuation, tip_force, tip_moment, distributed_force, distributed_moment, push)
        return pack_loads(self.parameters.tendon_count, self._weight, parts)

    def spread_push(self, place: float, half_width: float = 0.05) -> None:
        """Spread the push of later solutions over a stretch of the rod, as a parabola whose integral is the force.

        Args:
            place: place of its middle, as a part of the length, in [0, 1].
            half_width: half of the stretch, likewise; at least half a node's distance, so that every scheme sees it.

        Raises:
            ParameterError: a place off the rod, or no width.
        """
        self._data.push[:-1] = push_shape(self.scheme, self.nodes, self._data.ds, place, half_width)
        self._data.push[-1] = 0.0

    def load_tip(self, mass: float, inertia: ArrayLike = ZERO, offset: ArrayLike = ZERO) -> None:
        """Add a rigid body to the tip of later solutions, beside the parameters' own: it moves with the tip.

        Args:
            mass: [kg]; 0 takes it off again.
            inertia: diagonal about its centre of mass, body frame [kg m^2], shape (3,).
            offset: vector from the tip to its centre of mass, body frame [m], shape (3,).

        Raises:
            ParameterError: a negative or non-finite mass or inertia.
        """
        own, n = self.parameters, self.parameters.tendon_count
        body = TipBody(own.tip_mass, np.asarray(own.tip_inertia), np.asarray(own.tip_offset))
        body += TipBody.checked(mass, inertia, offset)
        record = self._data.constants
        record["tip_mass"], record["tip_offset"], record["tip_inertia"] = body.mass, body.offset, body.inertia
        self._weight[n : n + 3] = body.mass * np.asarray(own.gravity)

    def _check(self, state: RodState) -> None:
        """Refuse a state of another rod: kernels do not check bounds."""
        if state.levels.shape[1] != self._stages or state.unknowns.shape[1] != 6 + self.parameters.tendon_count:
            raise ParameterError("the state is of another rod: its scheme, nodes or tendons differ")

    def _new_profile(self) -> Profile:
        """Memory for the state along the rod."""
        return Profile(np.empty((self._stages, HISTORY)), np.empty((self.nodes, 12)))
