"""The rods that the physics tests bend, and what they share."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypedDict

import numpy as np
import numpy.typing as npt

from tendond.model import Rod, RodParameters, RodState
from tendond.model.solver.predictor import RING

Array = npt.NDArray[np.float64]

PAPER = RodParameters()
"""The paper's robot: 0.5 m of steel wire with gravity across it."""

WEIGHTLESS = replace(PAPER, gravity=(0.0, 0.0, 0.0))

CONSERVATIVE = replace(WEIGHTLESS, bending_damping=(0.0, 0.0, 0.0), drag=(0.0, 0.0, 0.0))
"""Nothing takes energy away but the time scheme."""

THREE_TENDONS = replace(PAPER, tendon_positions=tuple((0.02 * np.cos(at), 0.02 * np.sin(at)) for at in (0.1, 2.2, 4.5)))
"""Another number of tendons than four, at unequal angles."""


class External(TypedDict, total=False):
    """Loads that are no tendons', world frame: arguments of `Rod.solve_static` and `Rod.step`."""

    tip_force: Sequence[float]
    tip_moment: Sequence[float]
    distributed_force: Sequence[float]
    distributed_moment: Sequence[float]


def relative(found: Array, expected: Array) -> float:
    """Norm of the error over the norm of what is expected [-]; where that is zero, the norm of the error."""
    size = np.linalg.norm(expected)
    return float(np.linalg.norm(found - expected) / (size if size > 0.0 else 1.0))


def one_tendon(tension: float, tendon: int = 0, count: int = 4) -> Array:
    """Tension [N] on one tendon, none on the others, shape (count,)."""
    tensions = np.zeros(count)
    tensions[tendon] = tension
    return tensions


def tip_motion(rod: Rod, state: RodState) -> Array:
    """Position [m] and velocity [m/s] of the tip, world frame, shape (6,)."""
    tip = rod.tip(state)
    return np.concatenate([tip.position, tip.velocity])


def last_state(state: RodState) -> dict[str, Array]:
    """Arrays of a state that the next step may read, by name: all but the slots that it will write, and the Jacobian.

    The rings hold the last two levels, the last history and geometry, and all solutions but the oldest.
    """
    past = [(state.count - back) % RING for back in range(RING - 1)]
    return {
        "scalars": np.array([state.count, state.time, state.displacement_driven, state.residual, state.marches]),
        "levels": state.levels[[state.count % 3, (state.count + 2) % 3]],
        "history": state.histories[state.count % 2],
        "geometry": state.geometries[state.count % 2],
        "unknowns": state.unknowns[past],
        "loads": state.loads,
        "lengths": state.lengths,
    }


def identical(one: RodState, other: RodState) -> bool:
    """Bit for bit the same last state."""
    ones, others = last_state(one), last_state(other)
    return all(ones[name].tobytes() == others[name].tobytes() for name in ones)
