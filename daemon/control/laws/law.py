"""What a control law is: a pure function of what is known of the tip, to the tensions that it wants."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from tendond.daemon.control.actuation import net_tension, share
from tendond.model.tendons.allocation import Allocation

Array = NDArray[np.float64]
Pair = tuple[float, float]
"""Across and along the straight rod, in the bending plane."""


@dataclass(frozen=True)
class LawTerms:
    """Base of a law's terms: what it made of an observation, for the record and for plots; floats and pairs, SI."""


class LawParameters(BaseModel):
    """Base of a law's parameters; the configuration's table `control.laws.<law>` fills them."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


@dataclass(frozen=True)
class Outlook:
    """What a law that looks ahead knows of the coming step; vectors in the world frame.

    Attributes:
        period: of the cycle [s].
        position: of the tip after the step, if the tensions stay [m], shape (3,).
        answer: of that position to the tendons' bending moment [m/(N m)], shape (3, 2); see `Allocation`.
        target: of the reference at the end of the step [m], shape (3,).
        directions: in which the resting tip moves there, not normalised, shape (3, 2); none where that is not known.
        allocation: of a bending moment to tensions.
    """

    period: float
    position: Array
    answer: Array
    target: Array
    directions: Array | None
    allocation: Allocation


@dataclass(frozen=True)
class Observation:
    """What a law knows in one cycle; vectors in the world frame.

    Attributes:
        position: X1 [m], shape (3,).
        velocity: X2 [m/s], shape (3,).
        acceleration: of the tip at the tensions now applied [m/s^2], shape (3,).
        input_gain: b_c [m/s^2/N], shape (3, n).
        response: of the tip's velocity after a cycle to the agonist's tension [m/s/N], shape (3,); none: not asked for.
        tension: now applied [N], shape (n,).
        target, target_velocity, target_acceleration: of the reference [m, m/s, m/s^2], shape (3,).
        axes: the two world axes of the bending plane, e.g. (0, 2).
        agonist: index of the tendon that bends towards the first axis; antagonist: of the opposing one, if it is used.
        input_gain_min: below this size b_c has no direction, and its inverse grows no further [m/s^2/N].
        pair_tension: least tension of both tendons of the pair [N].
        outlook: on the coming step, for a law that looks ahead.
    """

    position: Array
    velocity: Array
    acceleration: Array
    input_gain: Array
    response: Array | None
    tension: Array
    target: Array
    target_velocity: Array
    target_acceleration: Array
    axes: tuple[int, int]
    agonist: int
    antagonist: int | None
    input_gain_min: float
    pair_tension: float
    outlook: Outlook | None = None

    def in_plane(self, vector: Array) -> Array:
        """The two components of a vector in the bending plane, shape (2,)."""
        across, along = self.axes
        return vector[across : along + 1 : along - across]

    def tensions_for(self, acceleration: Array, rate: float) -> tuple[Array, float]:
        """Tensions [N], shape (n,), that give the tip `acceleration` [m/s^2], shape (2,), in the plane; and their net.

        The paper's U = b_c^+ (-a_c + ...), of the agonist's column; see `actuation.net_tension` and `share`. `rate` is
        the law's gain on the velocity error, kd [1/s]: no more than all of that error is taken away in a cycle.
        """
        applied = float(self.tension[self.agonist])
        if self.antagonist is not None:
            applied -= float(self.tension[self.antagonist])
        gain = self.in_plane(self.input_gain[:, self.agonist])
        missing = acceleration - self.in_plane(self.acceleration)
        response = None if self.response is None else self.in_plane(self.response)
        net = net_tension(gain, missing, applied, self.input_gain_min, rate, response)
        return share(len(self.tension), self.agonist, self.antagonist, net, self.pair_tension), net


@dataclass(frozen=True)
class Decision:
    """What a law wants: tensions before any limit [N], shape (n,), and its terms."""

    tension: Array
    terms: LawTerms


@dataclass(frozen=True)
class Law:
    """A registered law.

    Attributes:
        name, parameters: its name, and its parameters' type.
        decide: the function.
        looks_ahead: it moves the tip in space with all tendons, and needs an `Outlook` for that; other laws move it in
            the bending plane, with the agonist or a pair.
    """

    name: str
    parameters: type[LawParameters]
    decide: Callable[[Any, Observation], Decision]
    looks_ahead: bool = False
