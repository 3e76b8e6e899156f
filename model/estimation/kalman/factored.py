"""A covariance as the factors U D U' of a matrix, with U unit upper triangular: it stays positive, whatever is rounded.

Prediction by weighted Gram-Schmidt (C. L. Thornton, "Triangular covariance factorizations for Kalman filtering", JPL TM
33-798, 1976), correction row by row (G. J. Bierman, "Factorization Methods for Discrete Sequential Estimation", 1977).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean

Array = NDArray[np.float64]


class Factors(NamedTuple):
    """Covariance P = U D U' of N errors.

    Attributes:
        columns: U, column by column: the row j holds U[0:j, j], then 1 and zeros, shape (N, N).
        spread: diagonal of D, shape (N,).
    """

    columns: Array
    spread: Array

    def copy(self) -> "Factors":
        """Return factors in memory of their own."""
        return Factors(self.columns.copy(), self.spread.copy())

    def along(self, rows: Array) -> Array:
        """Return the covariance of linear combinations, `rows` times the errors, shape (r, r)."""
        part = rows @ self.columns.T
        return np.asarray((part * self.spread) @ part.T)

    @property
    def covariance(self) -> Array:
        """P, shape (N, N)."""
        return np.asarray((self.columns.T * self.spread) @ self.columns)


def factors_of(covariance: Array) -> Factors:
    """Return the factors of a positive semidefinite matrix, shape (N, N)."""
    left, n = covariance.copy(), len(covariance)
    columns, spread = np.eye(n), np.zeros(n)
    for j in range(n - 1, -1, -1):
        spread[j] = max(left[j, j], 0.0)
        if spread[j] > 0.0:
            columns[j, :j] = left[:j, j] / spread[j]
            left[:j, :j] -= spread[j] * np.outer(columns[j, :j], columns[j, :j])
    return Factors(columns, spread)


@lean
def propagate(top: Any, decay: Any, noise: Any, old: Any, weight: Any, work: Any, columns: Any, spread: Any) -> None:
    """Write the factors of A P A' + Q.

    Args:
        top: first rows of A, shape (t, N); below, A is diagonal.
        decay: diagonal of A below them, shape (N - t,).
        noise: diagonal of Q there, shape (N - t,); above, Q is zero.
        old: columns of U, shape (N, N); weight: D, then room for `noise`, shape (2 N - t,), which is overwritten.
        work: room, shape (N, 2 N - t).
        columns, spread: take the new factors.
    """
    n, t = len(old), len(top)
    whole = 2 * n - t
    for i in range(n - t):
        weight[n + i] = noise[i]
    for i in range(t):
        for j in range(n):
            value = top[i, j]
            for l in range(j):
                value += top[i, l] * old[j, l]
            work[i, j] = value
        for j in range(n, whole):
            work[i, j] = 0.0
    for i in range(t, n):
        for j in range(whole):
            work[i, j] = 0.0
        factor = decay[i - t]
        work[i, i] = factor
        for j in range(i + 1, n):
            work[i, j] = factor * old[j, i]
        work[i, n + i - t] = 1.0
    for i in range(n - 1, -1, -1):
        total = 0.0
        for j in range(whole):
            total += weight[j] * work[i, j] * work[i, j]
        spread[i] = total
        for l in range(n):
            columns[i, l] = 0.0
        columns[i, i] = 1.0
        if total > 0.0:
            inverse = 1.0 / total
            for l in range(i):
                common = 0.0
                for j in range(whole):
                    common += weight[j] * work[i, j] * work[l, j]
                common *= inverse
                columns[i, l] = common
                if common != 0.0:
                    for j in range(whole):
                        work[l, j] -= common * work[i, j]


@lean
def correct(rows: Any, lack: Any, variance: Any, columns: Any, spread: Any, room: Any, deviation: Any) -> float:
    """Take measurements with independent noise, one after the other, in place.

    Args:
        rows: derivatives of the measured quantities by the errors, shape (r, N).
        lack: measured minus expected, where the errors are zero, shape (r,).
        variance: of the noise, shape (r,).
        columns, spread: factors of the covariance.
        room: shape (2, N).
        deviation: expected errors, shape (N,).

    Returns:
        The sum of squares of the innovations in units of their own spread: chi-square with r degrees of freedom.
    """
    n, nis = len(spread), 0.0
    for r in range(len(rows)):
        innovation = lack[r]
        for j in range(n):
            innovation -= rows[r, j] * deviation[j]
            value = rows[r, j]
            for i in range(j):
                value += columns[j, i] * rows[r, i]
            room[0, j] = value
            room[1, j] = spread[j] * value
        alpha = variance[r]
        gamma = 1.0 / alpha
        for j in range(n):
            beta, value = alpha, room[0, j]
            alpha += value * room[1, j]
            factor = -value * gamma
            gamma = 1.0 / alpha
            spread[j] *= beta * gamma
            gain = room[1, j]
            for i in range(j):
                kept = columns[j, i]
                columns[j, i] = kept + factor * room[1, i]
                room[1, i] += gain * kept
        for j in range(n):
            deviation[j] += room[1, j] * gamma * innovation
        nis += innovation * innovation * gamma
    return nis
