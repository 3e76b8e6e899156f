"""Space schemes by name: explicit Runge-Kutta tableaus as data."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError


@dataclass(frozen=True)
class Scheme:
    """An explicit Runge-Kutta method along the rod.

    Attributes:
        name: name by which it is selected.
        tableau: Butcher's a, shape (s, s), strictly lower triangular.
        weights: Butcher's b, shape (s,).
        order: order of convergence in the step length.
        nodes: default number of nodes, base and tip included.
        orthonormal: R is brought back to SO(3) after each step.
        trapezoidal: tendon lengths are the trapezoidal sum over the nodes, as in the paper; else the scheme's own sum.
        source: source of the coefficients.
    """

    name: str
    tableau: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    order: int
    nodes: int
    orthonormal: bool
    trapezoidal: bool
    source: str

    def arrays(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Tableau, shape (s, s), and weights, shape (s,)."""
        return np.array(self.tableau, dtype=np.float64), np.array(self.weights, dtype=np.float64)


EULER = Scheme(
    name="euler",
    tableau=((0.0,),),
    weights=(1.0,),
    order=1,
    nodes=200,
    orthonormal=False,
    trapezoidal=True,
    source="Danesh & Janabi-Sharifi, section 3: forward Euler, N = 200",
)

RK4 = Scheme(
    name="rk4",
    tableau=((0.0, 0.0, 0.0, 0.0), (0.5, 0.0, 0.0, 0.0), (0.0, 0.5, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)),
    weights=(1 / 6, 1 / 3, 1 / 3, 1 / 6),
    order=4,
    nodes=13,
    orthonormal=True,
    trapezoidal=False,
    source="Kutta 1901; Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I, table II.1.2",
)

RK6 = Scheme(
    name="rk6",
    tableau=(
        (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (1 / 3, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        (0.0, 2 / 3, 0.0, 0.0, 0.0, 0.0, 0.0),
        (1 / 12, 1 / 3, -1 / 12, 0.0, 0.0, 0.0, 0.0),
        (25 / 48, -55 / 24, 35 / 48, 15 / 8, 0.0, 0.0, 0.0),
        (3 / 20, -11 / 24, -1 / 8, 1 / 2, 1 / 10, 0.0, 0.0),
        (-261 / 260, 33 / 13, 43 / 156, -118 / 39, 32 / 195, 80 / 39, 0.0),
    ),
    weights=(13 / 200, 0.0, 11 / 40, 11 / 40, 4 / 25, 4 / 25, 13 / 200),
    order=6,
    nodes=6,
    orthonormal=True,
    trapezoidal=False,
    source="Butcher 1964, On Runge-Kutta processes of high order, J. Austral. Math. Soc. 4",
)

SCHEMES = {scheme.name: scheme for scheme in (EULER, RK4, RK6)}
DEFAULT = RK6.name


def scheme(name: str) -> Scheme:
    """The scheme of that name.

    Raises:
        ParameterError: no such scheme.
    """
    if name not in SCHEMES:
        raise ParameterError(f"space scheme {name!r} is unknown: choose one of {', '.join(SCHEMES)}")
    return SCHEMES[name]
