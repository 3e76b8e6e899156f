"""Tracking of poses with all tendons of a robot of sections: the inverse of its rests, and damping by the tendons.

The robot at rest under the tensions T that act now has its tip at the pose y(T), with the derivative E by all tensions.
The law asks for tensions with which it would rest at y_d, the goal of the coming step with the bend of the first mode
by its own inertia and damping there (`led_pose`),

    E dT = y_d - y(T)         within bounds, redundant tendons as planned: see `daemon.control.pose.allocation`

y(T) is computed anew in each cycle from the estimated state and load, so the linear step has no error that stays, and
a load or an error of the model that the observer has found moves y(T) and is taken away. It is an inverse by the model
(Garcia & Morari, Internal Model Control, 1982): where model and robot agree nothing is fed back that could swing.

What swings is the lightly damped robot itself. Each tendon takes its energy out, at its own place,

    T_i += -c (d_i' - d_i,d'),     c = damping / |dd'/dT|

d' is the rate of the displacements by the model, d_d' the reference's, and dd'/dT what a tension does to it in a step:
collocated feedback of a rate, which takes energy from every mode (Preumont, Vibration Control of Active Structures).
It takes little from a slow one, of a heavy tip. So the rest that is asked for moves against the tip's rate as well,

    y_d -= tau (y' - y_d'),     tau = 2 TIP_DAMPING / omega_1,   at most damping / |dy'/dy_d|

On a reference that begins with a jump of its velocity, as an exponential does, the arm cannot move with it: it is asked
to rest at y_d, and both rates are taken to be those of rest.

With y = q + relaxation q' + q''/omega^2 of the first mode this adds TIP_DAMPING to its damping ratio. Deflection and
slope of a cantilever's modes have the same sign at the tip, so a tendon that ends there takes energy from all of them.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.allocation import FREE, RIDGE, allocate
from tendond.daemon.control.pose.pose import counted, difference, turn
from tendond.daemon.control.pose.task import PoseObservation, RestObservation
from tendond.daemon.control.tasks.decision import Decision, LawTerms
from tendond.schemas.base import Vector3

Array = NDArray[np.float64]

TIP_DAMPING = 0.4
"""Damping ratio that the moved rest adds to the first mode: 0.1 leaves a slender arm with 15 g on its tip swinging by
0.6 mm after 4 s, 0.3 by less than a micrometre; with 0.7 an arm whose tool is 20 mm long swings."""


@dataclass(frozen=True)
class PoseTerms(LawTerms):
    """error: position [m]. turned: rotation vector to the reference [rad]. asked: of the rest's position [m].

    damping: largest tension by which a tendon damps [N]. lyapunov: half the square of the error, of what counts [m^2].
    """

    error: Vector3
    turned: Vector3
    asked: Vector3
    damping: float
    lyapunov: float


def follow_pose(observation: PoseObservation, agility: float, damping: float) -> Decision:
    """Return the tensions wanted and the terms.

    Args:
        observation: of the robot.
        agility: bound of the rate of every tension [N/s].
        damping: part of a tendon's rate that its tension takes away in a cycle [-].
    """
    one, still = observation, observation.still
    apart = difference(one.pose, one.now.pose, one.counts, one.radian)
    turned, lyapunov = turn(one.pose, one.now.pose, one.counts), 0.5 * float(apart @ apart)
    if still is None:  # the robot's rest is beyond the model: hold
        return Decision(one.tension, PoseTerms(_three(apart), _three(turned), (0.0, 0.0, 0.0), 0.0, lyapunov))
    jacobian = counted(still.rest.jacobian, still.pose, one.counts, one.radian)
    asked = difference(still.pose, one.led, one.counts, one.radian) - _tip_damping(one, still, jacobian, damping)
    step = agility * one.period
    low = np.clip(one.tension_min - one.tension, -step, step)
    high = np.clip(one.tension_max - one.tension, -step, step)
    change = allocate(jacobian, asked, one.tension, one.preferred, low, high)
    pulled = -_gain(still.mobility, damping) * (still.displacement_rate - _planned_rate(one, still, jacobian))
    tension = np.clip(one.tension + change + pulled, one.tension_min, one.tension_max)
    largest = float(np.max(np.abs(pulled)))
    return Decision(tension, PoseTerms(_three(apart), _three(turned), _three(asked), largest, lyapunov))


def _tip_damping(one: PoseObservation, still: RestObservation, jacobian: Array, damping: float) -> Array:
    """Return the way of the rest that damps the tip's motion, in the measure of `difference` [m], shape (6,)."""
    rate = counted(still.rate[:, None], still.pose, one.counts, one.radian)[:, 0]
    if not one.jumps:
        rate = rate - difference(one.now.pose, one.goal.pose, one.counts, one.radian) / one.period
    by_rest = counted(still.rate_jacobian, still.pose, one.counts, one.radian) @ np.linalg.pinv(jacobian, rcond=RIDGE)
    size = float(np.linalg.norm(by_rest, 2))
    time = min(2.0 * TIP_DAMPING / one.frequency, damping / size) if size > 0.0 else 0.0
    return np.asarray(time * rate)


def _planned_rate(one: PoseObservation, still: RestObservation, jacobian: Array) -> Array:
    """Return the rate of the tendons on the reference [m/s], shape (n,): the plan's, or that of passing its rests."""
    if one.jumps:
        return np.zeros(len(one.tension))
    if one.goal.displacement_rate is not None:
        return one.goal.displacement_rate
    moved = difference(one.now.pose, one.goal.pose, one.counts, one.radian)
    pulled = np.linalg.lstsq(jacobian, moved, rcond=FREE)[0]
    return np.asarray(still.rest.displacement_jacobian @ pulled / one.period)


def _gain(mobility: Array, damping: float) -> float:
    """Return c [N s/m]."""
    size = float(np.linalg.norm(mobility, 2))
    return damping / size if size > 0.0 else 0.0


def _three(values: Array) -> Vector3:
    x, y, z = values[:3].tolist()
    return x, y, z
