"""A rod's parameters, space scheme and time step as the kernels take them."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.solver.problem import WIDTHS, Bdf, RodData
from tendond.model.solver.schemes import Scheme
from tendond.model.solver.work import LANES

Array = NDArray[np.float64]

RESIDUAL_TOLERANCE = 1e-6
"""Default of the residual's norm at which a step counts as solved on the paper's robot [N], on others in proportion to
EI/L^2: such a force moves the tip of any straight rod by 5.6e-7 of its length."""

MARCH_BUDGET = 60
"""Marches that one solve may spend; a step of a smooth motion takes one or two."""


def kernel_width(tendons: int) -> int:
    """Return the width of the kernels for so many tendons; beyond the largest of `WIDTHS`, their number itself."""
    return next((width for width in WIDTHS if width >= tendons), tendons)


def discretise(parameters: RodParameters, scheme: Scheme, nodes: int, tolerance: float | None) -> RodData:
    """The rod as the kernels take it.

    Args:
        parameters: parameters of the rod.
        scheme: in space.
        nodes: base and tip included.
        tolerance: residual norm at which a step counts as solved [N]; see `RESIDUAL_TOLERANCE`.

    Raises:
        ParameterError: a value out of range.
    """
    if nodes < 2:
        raise ParameterError(f"nodes = {nodes} must be 2 or more")
    if tolerance is None:
        tolerance = RESIDUAL_TOLERANCE * parameters.force_scale
    if not 0.0 < tolerance < math.inf:
        raise ParameterError(f"tolerance = {tolerance} must be above 0 N")
    tableau, weights = scheme.arrays()
    unused = (0.0,) * (kernel_width(parameters.tendon_count) - parameters.tendon_count)
    return RodData(
        one=(0,),
        many=(0,) * LANES,
        tendons=parameters.tendon_count,
        x=tuple(float(x) for x, _ in parameters.tendon_positions) + unused,
        y=tuple(float(y) for _, y in parameters.tendon_positions) + unused,
        constants=parameters.constants(),
        tableau=tableau,
        weights=weights,
        push=np.zeros((nodes - 1) * len(weights) + 1),
        flags=(scheme.trapezoidal, scheme.orthonormal),
        steps=nodes - 1,
        ds=parameters.length / (nodes - 1),
        length=parameters.length,
        stiffness=parameters.tendon_stiffness,
        tolerance=tolerance,
        budget=MARCH_BUDGET,
    )


def bdf_alpha(time_step: float, alpha: float) -> Bdf:
    """Coefficients of BDF-alpha (Till, Aloi & Rucker 2019): y_t = c0 y + c1 y1 + c2 y2 + d1 y1_t.

    Args:
        time_step: [s].
        alpha: in [-0.5, 0]; 0 is BDF2, -0.5 the trapezoidal rule.

    Raises:
        ParameterError: a value out of range.
    """
    if not 0.0 < time_step < math.inf:
        raise ParameterError(f"time_step = {time_step} must be above 0 s")
    if not -0.5 <= alpha <= 0.0:
        raise ParameterError(f"alpha = {alpha} must lie in [-0.5, 0]")
    c0 = (1.5 + alpha) / (time_step * (1.0 + alpha))
    return c0, -2.0 / time_step, (0.5 + alpha) / (time_step * (1.0 + alpha)), alpha / (1.0 + alpha)


def gravity_loads(parameters: RodParameters) -> Array:
    """Loads of gravity, shape (n + 15,), in the order of `loads.pack_loads`."""
    n = parameters.tendon_count
    weight = np.zeros(n + 15)
    weight[n : n + 3] = parameters.tip_mass * np.asarray(parameters.gravity)
    weight[n + 6 : n + 9] = parameters.mass_per_length * np.asarray(parameters.gravity)
    return weight
