"""One implicit time step of the strain rod: an energy-consistent mean of both ends, solved by Newton's method.

With the modes q, their rates w and the mass points x(q), a step of length h from (q0, w0) solves for q1

    J' m ((x1 - x0) 2/h^2 - J0 w0 2/h) + K (q0 + q1) / 2 + e K (q1 - q0) + D (q1 - q0) / h = J' f + sum T_i d'_i,

J = (J0 + J1) / 2, d' likewise, with a share of q1 - q0 that makes J (q1 - q0) = x1 - x0 in the work of the forces: a
discrete gradient (O. Gonzalez, "Time integration and discrete Hamiltonian systems", J. Nonlinear Sci. 6, 1996).
Kinetic, elastic and gravity's energy then change by what the loads do, less what D and e dissipate, whatever the step:
nothing grows by itself, however light the damping. The load is held over the step, without a lag.
The rates after it are those of the modes nearest to the points' velocities, in the mass metric, which takes energy
away, and gives none. `e` is what keeps the fastest modes from ringing.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel
from tendond.model.strain.kinematics import Shape, curvature_of_points, empty_shape, find_shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.linear import cholesky, cholesky_solve, solve
from tendond.model.strain.tendons import Paths, add_tendon_stiffness, empty_paths, find_paths

Array = NDArray[np.float64]

ITERATIONS = 12
"""Of Newton's method; one that needs more is split into shorter steps."""

SPLITS = 10
"""Halvings of a step at most."""

DISSIPATION = 0.02
"""e: numerical damping of the modes that a step does not resolve, as a part of K over one step."""


ROUNDING = 1e-12
"""Of the work of all forces over the whole robot: below it, what the balance lacks is lost in rounding."""


GROWTH = 1e3
"""Of the residual's norm in one of Newton's steps, beyond which it is shortened: a stiff stretch grows first."""

ROUNDED = 1e-6
"""Times the tolerance: of the points' inertia, which is lost in rounding where a step is very short."""


class Loads(NamedTuple):
    """What acts on a robot over a step.

    Attributes:
        force: dead forces on the mass points, world frame [N], shape (P, 3).
        tension: of each tendon [N]; or its displacement [m] where `driven`. shape (m,).
        driven: whether a tendon is driven by displacement, shape (m,).
        moment: dead moments on the nodes, world frame [N m], shape (K + 1, 3).
    """

    force: Array
    tension: Array
    driven: NDArray[np.bool_]
    moment: Array


class Scratch(NamedTuple):
    """Arrays of a step: shapes and tendons at both ends, Newton's matrix and right-hand side, forces on the points."""

    before: Shape
    after: Shape
    paths_before: Paths
    paths_after: Paths
    matrix: Array
    residual: Array
    force: Array
    mean: Array
    velocity: Array
    taut: Array


def scratch_for(layout: Layout) -> Scratch:
    """Return arrays for the steps of this robot."""
    n, points, tendons = len(layout.component), len(layout.mass), len(layout.straight)
    return Scratch(
        empty_shape(layout), empty_shape(layout), empty_paths(layout), empty_paths(layout), np.zeros((n, n)),
        np.zeros(n), np.zeros((points, 3)), np.zeros((points, n, 3)), np.zeros((points, 3)), np.zeros(tendons),
    )  # fmt: skip


@kernel
def mass_matrix(layout, shape, out):  # type: ignore[no-untyped-def]
    """Write the mass matrix of a shape, shape (n, n)."""
    n = len(layout.component)
    out[:, :] = 0.0
    for j in range(len(layout.mass)):
        m = layout.mass[j]
        jacobian = shape.jacobian[j]
        for a in range(n):
            x, y, z = m * jacobian[a, 0], m * jacobian[a, 1], m * jacobian[a, 2]
            if x == 0.0 and y == 0.0 and z == 0.0:
                continue
            for b in range(a + 1):
                out[a, b] += x * jacobian[b, 0] + y * jacobian[b, 1] + z * jacobian[b, 2]
    for k in range(1, len(layout.polar)):
        inertia = layout.polar[k]
        for a in range(n):
            spin = inertia * shape.spin[k, a]
            if spin != 0.0:
                for b in range(a + 1):
                    out[a, b] += spin * shape.spin[k, b]
    for a in range(n):
        for b in range(a):
            out[b, a] = out[a, b]


@kernel
def _tensions(layout, loads, work):  # type: ignore[no-untyped-def]
    """Write the mean tension of each tendon over a step [N]."""
    for i in range(len(work.taut)):
        if loads.driven[i]:
            stretch = loads.tension[i] - 0.5 * (work.paths_before.displacement[i] + work.paths_after.displacement[i])
            work.taut[i] = layout.tendon_stiffness[i] * stretch if stretch > 0.0 else 0.0
        else:
            work.taut[i] = loads.tension[i]


@kernel
def _residual(layout, loads, q0, w0, q1, h, balanced, work):  # type: ignore[no-untyped-def]
    """Write the residual of a step that ends at q1; return its size, its largest part's, and its norm as energy."""
    n = len(q0)
    find_shape(layout, q1, work.after)
    find_paths(layout, q1, work.paths_after)
    _tensions(layout, loads, work)
    for a in range(n):
        mean = 0.0
        for b in range(n):
            k = layout.stiffness[a, b]
            d = layout.damping[a, b]
            if k != 0.0 or d != 0.0:
                change = q1[b] - q0[b]
                mean += k * (0.5 * (q0[b] + q1[b]) + DISSIPATION * change) + d * change / h
        work.residual[a] = mean
    size = 0.0
    for a in range(n):
        size = max(size, abs(work.residual[a]))
    for i in range(len(work.taut)):
        if work.taut[i] != 0.0:
            for a in range(n):
                pull = 0.5 * work.taut[i] * (work.paths_before.gradient[i, a] + work.paths_after.gradient[i, a])
                work.residual[a] -= pull
                size = max(size, abs(pull))
    for j in range(len(layout.mass)):
        m = layout.mass[j]
        v = np.empty(3)
        for i in range(3):
            v[i] = (work.after.point[j, i] - work.before.point[j, i]) / h
            work.force[j, i] = 2.0 * m / h * (v[i] - work.velocity[j, i]) - m * layout.gravity[i] - loads.force[j, i]
        if layout.drag[j, 0] != 0.0 or layout.drag[j, 1] != 0.0 or layout.drag[j, 2] != 0.0:
            r = 0.5 * (work.before.rotation[layout.place[j]] + work.after.rotation[layout.place[j]])
            for c in range(3):
                speed = r[c] * v[0] + r[3 + c] * v[1] + r[6 + c] * v[2]
                drag = layout.drag[j, c] * speed * abs(speed)
                for i in range(3):
                    work.force[j, i] += drag * r[3 * i + c]
        for a in range(n):
            for i in range(3):
                work.mean[j, a, i] = 0.5 * (work.before.jacobian[j, a, i] + work.after.jacobian[j, a, i])
            part = (
                work.mean[j, a, 0] * work.force[j, 0] + work.mean[j, a, 1] * work.force[j, 1]
                + work.mean[j, a, 2] * work.force[j, 2]
            )  # fmt: skip
            work.residual[a] += part
            lost = ROUNDED * 2.0 * m / (h * h) * (
                abs(work.after.point[j, 0] * work.mean[j, a, 0]) + abs(work.after.point[j, 1] * work.mean[j, a, 1])
                + abs(work.after.point[j, 2] * work.mean[j, a, 2])
            )  # fmt: skip
            size = max(size, abs(part), lost)
    for k in range(1, len(layout.polar)):
        inertia = layout.polar[k]
        rate = before = 0.0
        for a in range(n):
            rate += 0.5 * (work.before.spin[k, a] + work.after.spin[k, a]) * (q1[a] - q0[a]) / h
            before += work.before.spin[k, a] * w0[a]
        moment = 2.0 * inertia / h * (rate - before)
        x, y, z = loads.moment[k, 0], loads.moment[k, 1], loads.moment[k, 2]
        for a in range(n):
            work.residual[a] += 0.5 * (work.before.spin[k, a] + work.after.spin[k, a]) * moment
            if x != 0.0 or y != 0.0 or z != 0.0:
                one, two = work.before.twist[k, a], work.after.twist[k, a]
                part = 0.5 * (x * (one[0] + two[0]) + y * (one[1] + two[1]) + z * (one[2] + two[2]))
                work.residual[a] -= part
                size = max(size, abs(part))
    if balanced:
        _balance(layout, q0, q1, work)
    left = norm = 0.0
    for a in range(n):
        left = max(left, abs(work.residual[a]))
        norm += work.residual[a] ** 2 / layout.stiffness[a, a]
    return left, size, norm


@kernel
def _balance(layout, q0, q1, work):  # type: ignore[no-untyped-def]
    """Add what the mean Jacobians lack of the work of all forces along q1 - q0 (a discrete gradient)."""
    n = len(q0)
    norm = lacking = lost = 0.0
    for a in range(n):
        norm += layout.stiffness[a, a] * (q1[a] - q0[a]) ** 2
    for j in range(len(layout.mass)):
        for i in range(3):
            way = work.after.point[j, i] - work.before.point[j, i]
            for a in range(n):
                way -= work.mean[j, a, i] * (q1[a] - q0[a])
            lacking += work.force[j, i] * way
            lost += abs(work.force[j, i] * work.after.point[j, i])
    for i in range(len(work.taut)):
        way = work.paths_after.displacement[i] - work.paths_before.displacement[i]
        for a in range(n):
            way -= 0.5 * (work.paths_before.gradient[i, a] + work.paths_after.gradient[i, a]) * (q1[a] - q0[a])
        lacking -= work.taut[i] * way
        lost += work.taut[i] * layout.straight[i]
    if abs(lacking) <= ROUNDING * lost:
        return
    for a in range(n):
        work.residual[a] += lacking / norm * layout.stiffness[a, a] * (q1[a] - q0[a])


@kernel
def _matrix(layout, loads, q0, q1, h, work):  # type: ignore[no-untyped-def]
    """Write the derivative of the residual by q1, shape (n, n)."""
    n = len(q0)
    m = work.matrix
    m[:, :] = 0.0
    curvature_of_points(layout, work.after, work.force, m)
    add_tendon_stiffness(layout, q1, work.taut, 1.0, m)
    for a in range(n):
        for b in range(n):
            m[a, b] = 0.5 * m[a, b] + (0.5 + DISSIPATION) * layout.stiffness[a, b] + layout.damping[a, b] / h
    for j in range(len(layout.mass)):
        factor = 2.0 * layout.mass[j] / (h * h)
        mean, after = work.mean[j], work.after.jacobian[j]
        for a in range(n):
            x, y, z = factor * mean[a, 0], factor * mean[a, 1], factor * mean[a, 2]
            if x == 0.0 and y == 0.0 and z == 0.0:
                continue
            for b in range(n):
                m[a, b] += x * after[b, 0] + y * after[b, 1] + z * after[b, 2]
        if layout.drag[j, 0] != 0.0 or layout.drag[j, 1] != 0.0 or layout.drag[j, 2] != 0.0:
            r = 0.5 * (work.before.rotation[layout.place[j]] + work.after.rotation[layout.place[j]])
            for c in range(3):
                speed = 0.0
                for i in range(3):
                    speed += r[3 * i + c] * (work.after.point[j, i] - work.before.point[j, i]) / h
                slope = 2.0 * layout.drag[j, c] * abs(speed) / h
                if slope == 0.0:
                    continue
                for a in range(n):
                    left = slope * (r[c] * mean[a, 0] + r[3 + c] * mean[a, 1] + r[6 + c] * mean[a, 2])
                    for b in range(n):
                        m[a, b] += left * (r[c] * after[b, 0] + r[3 + c] * after[b, 1] + r[6 + c] * after[b, 2])
    for k in range(1, len(layout.polar)):
        factor = 2.0 * layout.polar[k] / (h * h)
        for a in range(n):
            left = 0.5 * factor * (work.before.spin[k, a] + work.after.spin[k, a])
            for b in range(n):
                m[a, b] += 0.5 * left * (work.before.spin[k, b] + work.after.spin[k, b])
    for i in range(len(work.taut)):
        if loads.driven[i] and work.taut[i] > 0.0:
            k = layout.tendon_stiffness[i]
            for a in range(n):
                left = 0.25 * k * (work.paths_before.gradient[i, a] + work.paths_after.gradient[i, a])
                for b in range(n):
                    m[a, b] += left * work.paths_after.gradient[i, b]


@kernel
def _solve_step(layout, loads, q0, w0, h, tolerance, guess, balanced, q1, w1, work):  # type: ignore[no-untyped-def]
    """Solve one step; return the iterations, -1 if they do not converge. `work.before` is the shape at q0."""
    n = len(q0)
    for j in range(len(layout.mass)):
        for i in range(3):
            value = 0.0
            for a in range(n):
                value += work.before.jacobian[j, a, i] * w0[a]
            work.velocity[j, i] = value
    for a in range(n):
        q1[a] = guess[a]
    left, size, norm = _residual(layout, loads, q0, w0, q1, h, balanced, work)
    count = 0
    trial = np.empty(n)
    while not left <= tolerance * size:
        count += 1
        if count > ITERATIONS or not np.isfinite(left):
            return -1
        _matrix(layout, loads, q0, q1, h, work)
        change = work.residual.copy()
        if not solve(work.matrix, change):
            return -1
        part = 1.0
        while True:
            for a in range(n):
                trial[a] = q1[a] - part * change[a]
            found, new, other = _residual(layout, loads, q0, w0, trial, h, balanced, work)
            if other < GROWTH * norm or found <= tolerance * new:
                break
            part *= 0.5
            if part < 0.05:
                return -1
        for a in range(n):
            q1[a] = trial[a]
        left, size, norm = found, new, other
    mass_matrix(layout, work.after, work.matrix)
    for a in range(n):
        w1[a] = 0.0
    for j in range(len(layout.mass)):
        m = layout.mass[j]
        for i in range(3):
            v = 2.0 * (work.after.point[j, i] - work.before.point[j, i]) / h - work.velocity[j, i]
            for a in range(n):
                w1[a] += m * v * work.after.jacobian[j, a, i]
    for k in range(1, len(layout.polar)):
        rate = before = 0.0
        for a in range(n):
            rate += 0.5 * (work.before.spin[k, a] + work.after.spin[k, a]) * (q1[a] - q0[a]) / h
            before += work.before.spin[k, a] * w0[a]
        for a in range(n):
            w1[a] += layout.polar[k] * (2.0 * rate - before) * work.after.spin[k, a]
    if not cholesky(work.matrix):
        return -1
    cholesky_solve(work.matrix, w1)
    return count


@kernel
def advance(layout, loads, q, w, h, tolerance, work):  # type: ignore[no-untyped-def]
    """Advance q and w by the time h, in place: one step, or, where that does not converge, as many shorter ones.

    Returns:
        Newton's iterations of all steps, and the number of steps; -1 for the first where even the shortest failed,
        with q and w as they were.
    """
    n = len(q)
    q0, w0 = q.copy(), w.copy()
    q1, w1, guess = np.empty(n), np.empty(n), np.empty(n)
    total = steps = 0
    done, parts = 0.0, 1.0
    find_shape(layout, q, work.before)
    find_paths(layout, q, work.paths_before)
    while done < 1.0 - 1e-12:
        step = min(1.0 / parts, 1.0 - done)
        for a in range(n):
            guess[a] = q[a] + step * h * w[a]
        count = _solve_step(layout, loads, q, w, step * h, tolerance, guess, True, q1, w1, work)
        if count < 0:
            count = _solve_step(layout, loads, q, w, step * h, tolerance, guess, False, q1, w1, work)
        if count < 0:
            parts *= 2.0
            if parts > 2.0**SPLITS:
                for a in range(n):
                    q[a], w[a] = q0[a], w0[a]
                return -1, steps
            continue
        total += count
        steps += 1
        done += step
        for a in range(n):
            q[a], w[a] = q1[a], w1[a]
        if done < 1.0 - 1e-12:
            find_shape(layout, q, work.before)
            find_paths(layout, q, work.paths_before)
    return total, steps
