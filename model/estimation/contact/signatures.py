"""Signatures: what a constant force that began at an onset has left in the filter's errors and innovations.

With the transition A, the response B to the force, the rows C and the gain K of the filter, a force of 1 N leaves the
error z and the innovation g,

    z-(k+1) = A z+(k) + B,    g = C z-,    z+ = (I - K C) z-,    z = 0 at the onset;

with the innovations nu and their covariance S, the information on the force is sum g' S^-1 g, the score sum g' S^-1 nu
(A. S. Willsky, H. L. Jones, "A generalized likelihood ratio approach to the detection and estimation of jumps in linear
systems", IEEE Trans. Autom. Control 21, 1976, eqs. 14 to 22). All in numbers of unit variance: L^-1 nu with S = L L'.
"""

import math
from typing import Any

from tendond.model.numerics.compile import lean


@lean
def whiten(
    rows: Any, variance: Any, innovation: Any, columns: Any, spread: Any, work: Any, white: Any, gain: Any
) -> bool:
    """Write a measurement in numbers of unit variance, and the filter's gain for them.

    Args:
        rows: C, shape (r, N). variance: of the noise, shape (r,).
        innovation: measured minus expected, shape (r,), which is overwritten by L^-1 nu.
        columns, spread: factors of the covariance before it, see `kalman.factored.Factors`.
        work: room, shape (2 r, max(r, N)).
        white: takes L^-1 C, shape (r, N). gain: takes K L, transposed, shape (r, N).

    Returns:
        False where the covariance of the innovation is not positive.
    """
    r, n = rows.shape
    for a in range(r):
        for j in range(n):
            value = rows[a, j]
            for i in range(j):
                value += columns[j, i] * rows[a, i]
            work[a, j] = value
        for i in range(n):
            gain[a, i] = 0.0
            white[a, i] = rows[a, i]
        for j in range(n):
            value = spread[j] * work[a, j]
            gain[a, j] += value
            for i in range(j):
                gain[a, i] += value * columns[j, i]
    for a in range(r):  # S, by its factor of Cholesky
        for b in range(a + 1):
            value = variance[a] if a == b else 0.0
            for i in range(n):
                value += rows[a, i] * gain[b, i]
            work[r + a, b] = value
    for a in range(r):
        for b in range(a + 1):
            value = work[r + a, b]
            for c in range(b):
                value -= work[r + a, c] * work[r + b, c]
            if a == b:
                if not value > 0.0:
                    return False
                work[r + a, a] = math.sqrt(value)
            else:
                work[r + a, b] = value / work[r + b, b]
    for a in range(r):
        inverse = 1.0 / work[r + a, a]
        for b in range(a):
            part = work[r + a, b]
            innovation[a] -= part * innovation[b]
            for i in range(n):
                white[a, i] -= part * white[b, i]
                gain[a, i] -= part * gain[b, i]
        innovation[a] *= inverse
        for i in range(n):
            white[a, i] *= inverse
            gain[a, i] *= inverse
    return True


@lean
def carry(top: Any, decay: Any, push: Any, errors: Any, work: Any) -> None:
    """Carry errors left by forces over a step: z- = A z+ + B, in place.

    Args:
        top: first rows of A, shape (2 k, N); decay: its diagonal below, shape (N - 2 k,).
        push: B, shape (2 k, 3 p).
        errors: of each window, shape (w, N, 3 p). work: room, shape (2 k, 3 p).
    """
    windows, n, columns = errors.shape
    t = len(top)
    for w in range(windows):
        for i in range(t):
            for c in range(columns):
                work[i, c] = push[i, c]
            for j in range(n):
                part = top[i, j]
                if part != 0.0:
                    for c in range(columns):
                        work[i, c] += part * errors[w, j, c]
        for i in range(t):
            for c in range(columns):
                errors[w, i, c] = work[i, c]
        for i in range(t, n):
            part = decay[i - t]
            for c in range(columns):
                errors[w, i, c] *= part


@lean
def heed(white: Any, gain: Any, innovation: Any, errors: Any, work: Any, information: Any, score: Any) -> None:
    """Take a measurement: g = C z-, z+ = z- - K g, information and score, in place.

    Args:
        white, gain, innovation: of unit variance, see `whiten`.
        errors: of each window, shape (w, N, 3 p). work: room, shape (r, 3 p).
        information: shape (w, p, 3, 3). score: shape (w, p, 3).
    """
    windows, n, columns = errors.shape
    r = len(innovation)
    for w in range(windows):
        for a in range(r):
            for c in range(columns):
                work[a, c] = 0.0
            for j in range(n):
                part = white[a, j]
                if part != 0.0:
                    for c in range(columns):
                        work[a, c] += part * errors[w, j, c]
        for j in range(n):
            for a in range(r):
                part = gain[a, j]
                for c in range(columns):
                    errors[w, j, c] -= part * work[a, c]
        for a in range(r):
            value = innovation[a]
            for p in range(columns // 3):
                for i in range(3):
                    left = work[a, 3 * p + i]
                    score[w, p, i] += left * value
                    for j in range(3):
                        information[w, p, i, j] += left * work[a, 3 * p + j]


@lean
def solve_three(matrix: Any, right: Any, out: Any) -> float:
    """Write the solution of a symmetric positive definite system of three; return its product with the right side."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    x, y, z = right[0], right[1], right[2]
    l10, l20 = b / a, c / a
    d, e, f = d - l10 * b, e - l10 * c, f - l20 * c
    y, z = y - l10 * x, z - l20 * x
    l21 = e / d
    f, z = f - l21 * e, z - l21 * y
    out[2] = z / f
    out[1] = y / d - l21 * out[2]
    out[0] = x / a - l10 * out[1] - l20 * out[2]
    return float(out[0] * right[0] + out[1] * right[1] + out[2] * right[2])


@lean
def weigh(information: Any, score: Any, prior: Any, room: Any, force: Any, statistic: Any) -> None:
    """Write the likeliest force of each window and place [N], and twice the log of its likelihood ratio.

    Args:
        information: shape (w, p, 3, 3). score: shape (w, p, 3). prior: information beforehand, shape (p, 3, 3).
        room: shape (3, 3). force: shape (w, p, 3). statistic: shape (w, p).
    """
    windows, places = statistic.shape
    for w in range(windows):
        for p in range(places):
            for a in range(3):
                for b in range(3):
                    room[a, b] = information[w, p, a, b] + prior[p, a, b]
            statistic[w, p] = solve_three(room, score[w, p], force[w, p])
