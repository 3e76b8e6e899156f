"""Backstepping (Danesh & Janabi-Sharifi, section 4.2, eq. Back8).

With z1 = Xd - X1 and z2 = X2 - Xd' - alpha1 z1,

    U = b_c^+ ( -a_c + z1 - alpha1 z2 - alpha1^2 z1 - alpha2 z2 + Xd'' )

The Lyapunov function V = (z1'z1 + z2'z2)/2 then falls as -alpha1 z1'z1 - alpha2 z2'z2, in continuous time and along the
directions that b_c reaches.
"""

from dataclasses import dataclass

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
    """alpha1, alpha2 [1/s]; the paper's values by default."""

    alpha1: Gain = 1500.0
    alpha2: Gain = 12.5


@dataclass(frozen=True)
class Terms(LawTerms):
    """z1: position error [m]. z2: of the velocity [m/s]. lyapunov: V [m^2, m^2/s^2]. net_tension: U [N]."""

    z1: Pair
    z2: Pair
    lyapunov: float
    net_tension: float


def decide(parameters: Parameters, observation: PlanarObservation) -> Decision:
    """Return the tensions wanted and the terms."""
    a1, a2 = parameters.alpha1, parameters.alpha2
    z1 = observation.in_plane(observation.target - observation.position)
    z2 = observation.in_plane(observation.velocity - observation.target_velocity) - a1 * z1
    acceleration = observation.in_plane(observation.target_acceleration) + z1 - a1 * z2 - a1**2 * z1 - a2 * z2
    tension, net = observation.tensions_for(acceleration, rate=a1 + a2)
    (p, q), (r, s) = z1.tolist(), z2.tolist()
    lyapunov = (p * p + q * q + (r * r + s * s)) / 2.0
    return Decision(tension, Terms(z1=(p, q), z2=(r, s), lyapunov=lyapunov, net_tension=net))


def rates(parameters: Parameters) -> Convergence:
    """Return the slow rate of z1'' + (alpha1 + alpha2) z1' + (1 + alpha1 alpha2) z1 = 0 for alpha1 >> alpha2."""
    a1, a2 = parameters.alpha1, parameters.alpha2
    return Convergence((1.0 + a1 * a2) / (a1 + a2))


LAW = StatelessLaw("backstepping", Parameters, decide, BENDING_PLANE, rates=rates)
