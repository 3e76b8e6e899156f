"""Points between the nodes of the backbone, with their derivatives by the strains.

A point is on the cubic through the positions x_k of the nodes along their directions t_k (`Backbone.weights`):

    p = sum_k a_k x_k + b_k t_k,    dp/dq = sum_k a_k (s_k x x_k + d_k) + b_k (s_k x t_k)

with the spatial twists (s_k, d_k) of the nodes by the strains.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.strain.kinematics import Shape, find_shape
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]


class PointWeights(NamedTuple):
    """Weights of the nodes, K + 1 of them, for p points.

    Attributes:
        places: a, of their positions [-], shape (p, K + 1). tangents: b, of their directions [m], shape (p, K + 1).
    """

    places: Array
    tangents: Array


@lean
def place_points(shape: Shape, weights: PointWeights, points: Array) -> None:
    """Write the points of a shape [m], shape (p, 3)."""
    for i in range(len(points)):
        x = y = z = 0.0
        for k in range(weights.places.shape[1]):
            a, b = weights.places[i, k], weights.tangents[i, k]
            if a != 0.0 or b != 0.0:
                x += a * shape.position[k, 0] + b * shape.rotation[k, 2]
                y += a * shape.position[k, 1] + b * shape.rotation[k, 5]
                z += a * shape.position[k, 2] + b * shape.rotation[k, 8]
        points[i, 0], points[i, 1], points[i, 2] = x, y, z


@lean
def find_points(layout: Layout, q: Array, shape: Shape, weights: PointWeights, points: Array, jacobians: Array) -> None:
    """Write the points of strains q [m], shape (p, 3), and their derivatives by them, shape (p, 3, n).

    Args:
        layout: of the robot. q: strains, shape (n,). shape: room for their shape.
    """
    find_shape(layout, q, shape)
    place_points(shape, weights, points)
    for i in range(len(points)):
        for c in range(3):
            for a in range(len(q)):
                jacobians[i, c, a] = 0.0
        for k in range(weights.places.shape[1]):
            along, across = weights.places[i, k], weights.tangents[i, k]
            if along != 0.0 or across != 0.0:
                x = along * shape.position[k, 0] + across * shape.rotation[k, 2]
                y = along * shape.position[k, 1] + across * shape.rotation[k, 5]
                z = along * shape.position[k, 2] + across * shape.rotation[k, 8]
                for a in range(len(q)):
                    u, v, w = shape.twist[k, 0, a], shape.twist[k, 1, a], shape.twist[k, 2, a]
                    jacobians[i, 0, a] += v * z - w * y + along * shape.twist[k, 3, a]
                    jacobians[i, 1, a] += w * x - u * z + along * shape.twist[k, 4, a]
                    jacobians[i, 2, a] += u * y - v * x + along * shape.twist[k, 5, a]
