"""Tracking in space with all tendons, by the rod's own sensitivities; docs/space.md derives it.

The prediction says where the tip will be after the coming step if the tensions stay (p0), and the jacobian E = dp/dM,
shape (3, 2), by the tendons' bending moment M. It has rank 2 on the straight rod too, where the paper's b_c vanishes.
With the error e = Xd - X1 now and the reference Xd+ of the step's end, the law asks for a tip whose error is a fixed
part of that, in the two directions S in which the resting tip can move:

    S'E dM = S'(Xd+ - p0 - d - exp(-rate dt) e)

d is what the measured tip is beside the model's. Without error M stays: the law is incremental, as the paper's are.
Because reference and prediction are of one time, a moving target is followed without lag. `Allocation` makes tensions
of M, so that none is below the pretension.

Robots of sections, those that would swing, and references of poses take `rest_inverse` instead.
"""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tendond.daemon.control.laws.law import (
    GAIN_RATE,
    Convergence,
    Decision,
    LawParameters,
    LawTerms,
    SpatialObservation,
    StatelessLaw,
)
from tendond.daemon.control.laws.rest_inverse import follow_pose
from tendond.daemon.control.pose.task import PoseObservation
from tendond.daemon.control.tasks.observation import Prediction
from tendond.daemon.control.tasks.space import SPACE
from tendond.schemas.base import Vector3
from tendond.schemas.config.tunable import tunable

Array = NDArray[np.float64]


class Parameters(LawParameters):
    """rate, smoothing: at which the error decays, and its decay sets in [1/s].

    agility: bound of the rate at which a tendon is tightened for it [N/s]. damping: of the inverse, as a part of the
    sensitivity's size [-]. Of poses and robots of sections: active_damping: part of a tendon's rate that its tension
    takes away in a cycle [-]; rate, smoothing and damping have no effect there.
    """

    rate: Annotated[float, Field(gt=0.0, le=1e4, json_schema_extra=tunable(GAIN_RATE))] = 30.0
    smoothing: Annotated[float, Field(gt=0.0, le=1e4, json_schema_extra=tunable(GAIN_RATE))] = 100.0
    agility: Annotated[float, Field(gt=0.0, le=1e6, json_schema_extra=tunable(GAIN_RATE))] = 350.0
    damping: Annotated[float, Field(ge=0.0, le=1.0)] = 0.02
    active_damping: Annotated[float, Field(ge=0.0, le=0.5)] = 0.2


@dataclass(frozen=True)
class Terms(LawTerms):
    """error: e [m]. asked: what is missing after the step at the present tensions [m]. moment: M [N m].

    lyapunov: e'e / 2 [m^2], which falls by exp(-2 rate dt) in a step where S holds e.
    """

    error: Vector3
    asked: Vector3
    moment: tuple[float, float]
    lyapunov: float


def decide(parameters: Parameters, observation: SpatialObservation | PoseObservation) -> Decision:
    """Return the tensions wanted and the terms; those for poses are `rest_inverse`'s."""
    if isinstance(observation, PoseObservation):
        return follow_pose(observation, parameters.agility, parameters.active_damping)
    prediction, period = observation.prediction, observation.period
    error = observation.target - observation.position
    if prediction is None:  # the coming step is beyond the model: hold
        x, y, z = error.tolist()
        return Decision(
            observation.tension, Terms((x, y, z), (0.0, 0.0, 0.0), (0.0, 0.0), 0.5 * (x * x + y * y + z * z))
        )
    slow, fast = math.exp(-parameters.rate * period), math.exp(-parameters.smoothing * period)
    error_rate = observation.target_velocity - observation.velocity
    kept = (slow + fast - slow * fast) * error + slow * fast * period * error_rate
    asked = prediction.target - prediction.position - kept
    change = _moment(prediction, asked, parameters.damping)
    change_max = parameters.agility * period * prediction.allocation.arm_max
    moment = prediction.allocation.moment(observation.tension) + change * min(
        1.0, change_max / max(math.hypot(*change), change_max)
    )
    x, y, z = error.tolist()
    u, v, w = asked.tolist()
    return Decision(
        prediction.allocation.tensions(moment),
        Terms(
            error=(x, y, z),
            asked=(u, v, w),
            moment=(float(moment[0]), float(moment[1])),
            lyapunov=0.5 * (x * x + y * y + z * z),
        ),
    )


def _moment(prediction: Prediction, asked: Array, damping: float) -> Array:
    """dM [N m], shape (2,), that moves the tip by `asked` [m] where it can: the damped inverse of S'E."""
    a = b = c = d = p = q = 0.0
    jacobian = prediction.jacobian.tolist()
    directions = jacobian if prediction.directions is None else prediction.directions.tolist()
    for (s0, s1), (e0, e1), missing in zip(directions, jacobian, asked.tolist(), strict=True):
        a, b, p = a + s0 * e0, b + s0 * e1, p + s0 * missing
        c, d, q = c + s1 * e0, d + s1 * e1, q + s1 * missing
    ridge = damping**2 * (a * a + b * b + c * c + d * d)
    # (A'A + ridge) dM = A' b
    g, h, k = a * a + c * c + ridge, a * b + c * d, b * b + d * d + ridge
    r, s = a * p + c * q, b * p + d * q
    determinant = g * k - h * h
    if not determinant > 0.0:
        return np.zeros(2)
    return np.array([(k * r - h * s) / determinant, (g * s - h * r) / determinant])


def rates(parameters: Parameters) -> Convergence:
    """Return the rates of the error's decay."""
    return Convergence(parameters.rate, parameters.smoothing)


LAW = StatelessLaw("sensitivity", Parameters, decide, SPACE, rates=rates)
