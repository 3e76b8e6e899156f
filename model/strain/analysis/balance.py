"""Balance of energy over a step: what loads put in, what is stored, and what is lost."""

from dataclasses import dataclass

import numpy as np

from tendond.model.strain.friction.along import cell_shortening
from tendond.model.strain.kinematics import empty_shape, find_shape
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.energies import energies
from tendond.model.strain.stepping.scratch import Loads


@dataclass(frozen=True)
class Energy:
    """Energy of a state [J]: motion, strain of the backbone, and weight; the last is 0 at the world's origin."""

    kinetic: float
    elastic: float
    weight: float

    @property
    def total(self) -> float:
        """The sum [J]."""
        return self.kinetic + self.elastic + self.weight


@dataclass(frozen=True)
class Balance:
    """Balance of a step [J]; divided by its length, of the mean powers [W].

    Attributes:
        before, after: energies at both ends.
        tendons: work of the tendons on the backbone. forces: work of dead forces. moments: work of dead moments.
        lost: what damping, drag and the scheme take away, the works less the gain in energy.
    """

    before: Energy
    after: Energy
    tendons: float
    forces: float
    moments: float

    @property
    def lost(self) -> float:
        """Energy that is neither stored nor comes from outside [J]; not negative, but for rounding."""
        return self.tendons + self.forces + self.moments - (self.after.total - self.before.total)


def energy_of(rod: StrainRod, state: StrainState) -> Energy:
    """Return the energy of a state, by what holds it."""
    return Energy(*energies(rod.layout, rod.shape(state), state.strain, state.rate, state.base))


def balance_of(rod: StrainRod, before: StrainState, after: StrainState, loads: Loads) -> Balance:
    """Return the balance between two states, one step apart, under the loads that acted over it.

    The tension of a tendon that is driven by displacement is taken as in the step, at the mean of both ends; those
    along a tendon with friction at the step's end, so that what is lost does not hold friction's work on the tendon.
    """
    layout = rod.layout
    one, two = empty_shape(layout), empty_shape(layout)
    find_shape(layout, before.strain, one)
    find_shape(layout, after.strain, two)
    start, end = rod.displacements(before), rod.displacements(after)
    stretch = np.maximum(0.0, loads.tension - 0.5 * (start + end))
    tension = np.where(loads.driven, layout.tendon_stiffness * stretch, loads.tension)
    pulled = float(tension @ (end - start))
    if after.pulls is not None:
        rubbing = layout.friction > 0.0
        change = cell_shortening(rod, after) - cell_shortening(rod, before)
        pulled = float((tension * ~rubbing) @ (end - start)) + float(np.sum(after.pulls[:, 1:] * change))
    turned = 0.5 * (one.twist + two.twist)[:, :3, : rod.modes] @ (after.strain - before.strain)
    return Balance(
        energy_of(rod, before),
        energy_of(rod, after),
        pulled,
        float(np.sum(loads.force * (two.point - one.point))),
        float(np.sum(loads.moment * turned)),
    )
