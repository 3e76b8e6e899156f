"""Inputs of a control law: the tip, the reference, and the model's sensitivities. Vectors are in the world frame."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import net_tension, net_tension_of_step, share
from tendond.model.tendons.allocation import Allocation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlanarObservation:
    """Inputs of a law that moves the tip in the bending plane, with one tendon or an opposing pair.

    Attributes:
        position: X1 [m], shape (3,).
        velocity: X2 [m/s], shape (3,).
        acceleration: acceleration of the tip at the tensions now applied [m/s^2], shape (3,).
        input_gain: b_c [m/s^2/N], shape (3, n).
        velocity_jacobian: derivative of the tip's velocity after a cycle by the agonist's tension [m/s/N], shape (3,);
            none where `control.sampled` is off, or not needed.
        tension: tension now applied [N], shape (n,).
        target, target_velocity, target_acceleration: reference [m, m/s, m/s^2], shape (3,).
        axes: the two world axes of the bending plane, e.g. (0, 2).
        agonist: index of the tendon that bends towards the first axis; antagonist: the opposing one, if it is used.
        input_gain_min: size below which b_c has no direction, and its inverse grows no further [m/s^2/N].
        pair_tension: minimum tension of both tendons of the pair [N].
        period: period of the cycle [s].
        whole_steps: acceleration and b_c are those of the coming step, and a law is to be sampled by them.
    """

    position: Array
    velocity: Array
    acceleration: Array
    input_gain: Array
    velocity_jacobian: Array | None
    tension: Array
    target: Array
    target_velocity: Array
    target_acceleration: Array
    axes: tuple[int, int]
    agonist: int
    antagonist: int | None
    input_gain_min: float
    pair_tension: float
    period: float
    whole_steps: bool = False

    def in_plane(self, vector: Array) -> Array:
        """Return the two components of a vector in the bending plane, shape (2,)."""
        across, along = self.axes
        return vector[across : along + 1 : along - across]

    def tensions_for(self, acceleration: Array, rate: float) -> tuple[Array, float]:
        """Return tensions [N], shape (n,), that give the tip `acceleration` in the plane, and their net tension [N].

        The paper's U = b_c^+ (-a_c + ...), of the agonist's column; see `actuation.net_tension` and `share`.

        Args:
            acceleration: wanted, in the plane [m/s^2], shape (2,).
            rate: kd, the law's gain on the velocity error [1/s]: at most all of that error is removed in one cycle.
        """
        applied = float(self.tension[self.agonist])
        if self.antagonist is not None:
            applied -= float(self.tension[self.antagonist])
        gain, present = self.in_plane(self.input_gain[:, self.agonist]), self.in_plane(self.acceleration)
        if self.whole_steps:
            net = net_tension_of_step(gain, acceleration, present, applied, self.input_gain_min, rate, self.period)
        else:
            jacobian = None if self.velocity_jacobian is None else self.in_plane(self.velocity_jacobian)
            net = net_tension(gain, acceleration - present, applied, self.input_gain_min, rate, jacobian)
        return share(len(self.tension), self.agonist, self.antagonist, net, self.pair_tension), net


@dataclass(frozen=True)
class Prediction:
    """The coming step by the model's linearisation.

    Attributes:
        position: tip after the step at unchanged tensions: position [m] or direction [-], shape (3,).
        jacobian: derivative of `position` by the tendons' bending moment [m/(N m)], shape (3, 2); see `Allocation`.
        target: reference at the end of the step [m], shape (3,).
        directions: directions in which the resting tip moves there, not normalised, shape (3, 2); none where they are
            not known.
        allocation: map from a bending moment to tensions.
    """

    position: Array
    jacobian: Array
    target: Array
    directions: Array | None
    allocation: Allocation


@dataclass(frozen=True)
class SpatialObservation:
    """Inputs of a law that moves the tip in space, with all tendons; a place is a position [m] or a direction [-].

    Attributes:
        position, velocity: place of the tip and its derivative by time, shape (3,).
        target, target_velocity: point of the reference now, shape (3,).
        tension: tension now applied [N], shape (n,).
        period: period of the cycle [s].
        prediction: the coming step; none where the model has no solution for it.
    """

    position: Array
    velocity: Array
    target: Array
    target_velocity: Array
    tension: Array
    period: float
    prediction: Prediction | None
