"""Sliding mode with the exponential reaching law (Danesh & Janabi-Sharifi, section 4.1, eq. Sdot3).

With e = Xd - X1 and S = e' + c e,

    U = b_c^+ ( c e' + Xd'' - a_c + epsilon sgn(S) + k S )

The Lyapunov function V = S'S/2 then falls as -k S'S - epsilon |S|, in continuous time and along the directions that b_c
reaches.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from pydantic import Field

from tendond.daemon.control.laws.law import (
    Convergence,
    Decision,
    Gain,
    LawParameters,
    LawTerms,
    Pair,
    PlanarObservation,
    StatelessLaw,
)
from tendond.daemon.control.tasks.plane import BENDING_PLANE


class Parameters(LawParameters):
    """c, k [1/s], epsilon [m/s^2]; the paper's values by default."""

    c: Gain = 2100.0
    k: Gain = 12.0
    epsilon: Annotated[float, Field(ge=0.0, le=1e3)] = 0.005


@dataclass(frozen=True)
class Terms(LawTerms):
    """error: e [m]. surface: S [m/s]. lyapunov: V [m^2/s^2]. net_tension: U [N]."""

    error: Pair
    surface: Pair
    lyapunov: float
    net_tension: float


def decide(parameters: Parameters, observation: PlanarObservation) -> Decision:
    """Return the tensions wanted and the terms."""
    error = observation.in_plane(observation.target - observation.position)
    error_rate = observation.in_plane(observation.target_velocity - observation.velocity)
    surface = error_rate + parameters.c * error
    acceleration = (
        observation.in_plane(observation.target_acceleration)
        + parameters.c * error_rate
        + parameters.epsilon * np.sign(surface)
        + parameters.k * surface
    )
    tension, net = observation.tensions_for(acceleration, rate=parameters.c + parameters.k)
    (p, q), (r, s) = error.tolist(), surface.tolist()
    return Decision(tension, Terms(error=(p, q), surface=(r, s), lyapunov=(r * r + s * s) / 2.0, net_tension=net))


def rates(parameters: Parameters) -> Convergence:
    """Return the slow rate of e'' + (c + k) e' + c k e = 0 for rates that are far apart."""
    return Convergence(parameters.c * parameters.k / (parameters.c + parameters.k))


LAW = StatelessLaw("sliding_mode", Parameters, decide, BENDING_PLANE, rates=rates)
