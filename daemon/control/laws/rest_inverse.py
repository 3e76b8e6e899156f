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
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.allocation import allocate
from tendond.daemon.control.pose.pose import counted, difference, turn
from tendond.daemon.control.pose.task import PoseObservation
from tendond.daemon.control.tasks.decision import Decision, LawTerms
from tendond.schemas.base import Vector3

Array = NDArray[np.float64]


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
    asked = difference(still.pose, one.led, one.counts, one.radian)
    jacobian = counted(still.rest.jacobian, still.pose, one.counts, one.radian)
    step = agility * one.period
    low = np.clip(one.tension_min - one.tension, -step, step)
    high = np.clip(one.tension_max - one.tension, -step, step)
    change = allocate(jacobian, asked, one.tension, one.goal.tension, low, high)
    pulled = -_gain(still.mobility, damping) * (still.displacement_rate - one.goal.displacement_rate)
    tension = np.clip(one.tension + change + pulled, one.tension_min, one.tension_max)
    largest = float(np.max(np.abs(pulled)))
    return Decision(tension, PoseTerms(_three(apart), _three(turned), _three(asked), largest, lyapunov))


def _gain(mobility: Array, damping: float) -> float:
    """Return c [N s/m]."""
    size = float(np.linalg.norm(mobility, 2))
    return damping / size if size > 0.0 else 0.0


def _three(values: Array) -> Vector3:
    x, y, z = values[:3].tolist()
    return x, y, z
