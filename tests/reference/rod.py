"""The rod's parameters and what follows from them: stiffness, inertia and the BDF-alpha coefficients.

Defaults are those of Danesh and Janabi-Sharifi (table 1 and section 5), with Poisson's ratio 0.3, which they leave
open.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from math import pi

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def vector(*components: float) -> Array:
    """The components as an array, shape (n,)."""
    return np.array(components, dtype=np.float64)


def hat(a: Array) -> Array:
    """The matrix of a x, shape (3, 3)."""
    x, y, z = a
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def four_tendons(offset: float) -> Array:
    """Four tendons [m] at `offset` from the backbone on +x, +y, -x, -y, body frame, shape (4, 3)."""
    return offset * np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])


@dataclass(frozen=True, eq=False)
class ReferenceRod:
    """A round, uniform rod with tendons parallel to its backbone, clamped at s = 0. SI units, n tendons."""

    length: float = 0.5
    """L [m]."""
    radius: float = 1e-3
    """Radius of the cross-section [m]."""
    youngs_modulus: float = 190e9
    """E [Pa]."""
    density: float = 17189.0
    """rho [kg/m^3]: the backbone with disks, glue and markers on it."""
    poisson_ratio: float = 0.3
    """nu [-]: G = E / (2 (1 + nu))."""
    shear_damping: Array = field(default_factory=lambda: np.zeros(3))
    """Diagonal of Bse [N s], body frame, shape (3,)."""
    bending_damping: Array = field(default_factory=lambda: np.full(3, 0.008))
    """Diagonal of Bbt [N m^2 s], body frame, shape (3,)."""
    drag: Array = field(default_factory=lambda: np.full(3, 0.1))
    """Diagonal of C [kg/m^2], body frame, shape (3,): the drag is C q |q|, component by component."""
    tendon_positions: Array = field(default_factory=lambda: four_tendons(0.02))
    """r_i = (x, y, 0) [m], body frame, shape (n, 3)."""
    gravity: Array = field(default_factory=lambda: vector(-9.81, 0.0, 0.0))
    """g [m/s^2], world frame, shape (3,)."""
    v_star: Array = field(default_factory=lambda: vector(0.0, 0.0, 1.0))
    """v* [-], unloaded, body frame, shape (3,)."""
    u_star: Array = field(default_factory=lambda: np.zeros(3))
    """u* [1/m], unloaded, body frame, shape (3,)."""
    tip_mass: float = 0.0
    """Mass of a rigid body on the tip [kg]."""
    tip_inertia: Array = field(default_factory=lambda: np.zeros(3))
    """Diagonal of its inertia about its centre of mass [kg m^2], body frame, shape (3,)."""
    tip_offset: Array = field(default_factory=lambda: np.zeros(3))
    """Vector from the tip to its centre of mass [m], body frame, shape (3,)."""
    dt: float = 0.01
    """Time step [s]."""
    alpha: float = -0.2
    """The parameter of BDF-alpha [-]; 0 is BDF2, -0.5 the trapezoidal rule."""

    @cached_property
    def area(self) -> float:
        """A [m^2]."""
        return pi * self.radius**2

    @cached_property
    def second_moment(self) -> float:
        """I [m^4] about a diameter; the polar moment is 2 I."""
        return pi * self.radius**4 / 4.0

    @cached_property
    def shear_modulus(self) -> float:
        """G [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @cached_property
    def Kse(self) -> Array:
        """Shear and extension stiffness diag(GA, GA, EA) [N], shape (3, 3)."""
        return np.diag([self.shear_modulus, self.shear_modulus, self.youngs_modulus]) * self.area

    @cached_property
    def Kbt(self) -> Array:
        """Bending and torsion stiffness diag(EI, EI, GJ) [N m^2], shape (3, 3)."""
        EI = self.youngs_modulus * self.second_moment
        return np.diag([EI, EI, self.shear_modulus * 2.0 * self.second_moment])

    @cached_property
    def Bse(self) -> Array:
        """Shear and extension damping [N s], shape (3, 3)."""
        return np.diag(self.shear_damping)

    @cached_property
    def Bbt(self) -> Array:
        """Bending and torsion damping [N m^2 s], shape (3, 3)."""
        return np.diag(self.bending_damping)

    @cached_property
    def C(self) -> Array:
        """Drag [kg/m^2], shape (3, 3)."""
        return np.diag(self.drag)

    @cached_property
    def tendon_hats(self) -> Array:
        """hat(r_i) [m], shape (n, 3, 3)."""
        return np.array([hat(r) for r in self.tendon_positions])

    @cached_property
    def rhoA(self) -> float:
        """Mass per length [kg/m]."""
        return self.density * self.area

    @cached_property
    def rhoJ(self) -> Array:
        """Rotational inertia per length, rho diag(I, I, 2 I) [kg m], shape (3, 3)."""
        return self.density * self.second_moment * np.diag([1.0, 1.0, 2.0])

    @property
    def c0(self) -> float:
        """BDF-alpha: the weight of y(i) in y_t(i) [1/s]."""
        return (1.5 + self.alpha) / (self.dt * (1.0 + self.alpha))

    @property
    def c1(self) -> float:
        """BDF-alpha: the weight of y(i-1) [1/s]."""
        return -2.0 / self.dt

    @property
    def c2(self) -> float:
        """BDF-alpha: the weight of y(i-2) [1/s]."""
        return (0.5 + self.alpha) / (self.dt * (1.0 + self.alpha))

    @property
    def d1(self) -> float:
        """BDF-alpha: the weight of y_t(i-1) [-]."""
        return self.alpha / (1.0 + self.alpha)
