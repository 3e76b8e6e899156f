"""The balance of one time step of the strain rod, and its derivative: an energy-consistent mean of both ends.

With the modes q, their rates w and the mass points x(q), a step of length h from (q0, w0) solves for q1

    J' m ((x1 - x0) 2/h^2 - J0 w0 2/h) + K (q0 + q1) / 2 + e K (q1 - q0) + D (q1 - q0) / h = J' f + sum T_i d'_i,

J = (J0 + J1) / 2, d' likewise, with a share of q1 - q0 that makes J (q1 - q0) = x1 - x0 in the work of the forces: a
discrete gradient (O. Gonzalez, "Time integration and discrete Hamiltonian systems", J. Nonlinear Sci. 6, 1996).
Kinetic, elastic and gravity's energy then change by what the loads do, less what D and e dissipate, whatever the step:
nothing grows by itself, however light the damping. The load is held over the step, without a lag. `e` is what keeps the
fastest modes from ringing.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.parked import park
from tendond.model.numerics.products import add_products, padded
from tendond.model.numerics.vectors import Vector
from tendond.model.strain.kinematics import Shape, curvature_of_points, empty_shape, find_shape
from tendond.model.strain.layout import BENDING_Y, STRETCH, Layout
from tendond.model.strain.tendons import Paths, add_tendon_stiffness, empty_paths, find_paths

Array = NDArray[np.float64]

DISSIPATION = 0.02
"""e: numerical damping of the modes that a step does not resolve, as a part of K over one step."""

STILL = 1e-6
"""[rad] A change below it, in the measure of energy, has no balance to keep: what it lacks is lost in rounding."""


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
    """Arrays of a step, kept from call to call so that none is allocated in it.

    Attributes:
        before, after: shapes at both ends. paths_before, paths_after: tendons there.
        matrix: derivative of the residual by q1, or its factors, shape (n, n). rows: of its pivots, shape (n,).
        residual: shape (n,). force: on the mass points, shape (P, 3). velocity: of them at q0, shape (P, 3).
        spin: rotation rates of the nodes at q0, shape (K + 1,); torque: moments of inertia on them, shape (K + 1,).
        taut: mean tensions, shape (m,); slack: their derivatives by the displacement at the end, shape (m,).
        elastic: the linear part of the matrix, shape (n, n); held: of the residual, shape (n,).
        scale: rotation or stretch per unit of each mode, squared, shape (n,).
        unit: energy of bending by 1 rad [J], then share and norm of the balance, shape (3,).
        q0, w0, q1, w1, trial, change, correction, pull, push, row: vectors, shape (n,).
        hessian: second derivative of the energy, shape (n, n).
        left, right, total: matrices for `add_products`.
    """

    before: Shape
    after: Shape
    paths_before: Paths
    paths_after: Paths
    matrix: Array
    rows: NDArray[np.int64]
    residual: Array
    force: Array
    velocity: Array
    spin: Array
    torque: Array
    taut: Array
    slack: Array
    elastic: Array
    held: Array
    scale: Array
    unit: Array
    q0: Array
    w0: Array
    q1: Array
    w1: Array
    trial: Array
    change: Array
    correction: Array
    pull: Array
    push: Array
    row: Array
    hessian: Array
    left: Array
    right: Array
    total: Array


def scratch_for(layout: Layout) -> Scratch:
    """Return arrays for the steps of this robot."""
    n, points, tendons, nodes = len(layout.component), len(layout.mass), len(layout.straight), len(layout.polar)
    width = padded.py_func(n)  # numba compiles a call from Python anew in each process
    lengths = np.zeros(n)
    for first, last, step in zip(layout.first, layout.last, layout.step, strict=True):
        lengths[first:last] += step
    scale = np.where(layout.component < STRETCH - 2, lengths**2, 1.0) / (2.0 * layout.order + 1.0)
    bends = (layout.component <= BENDING_Y) & (layout.order == 0)
    unit = np.min(np.diag(layout.stiffness)[bends] / lengths[bends] ** 2)
    vectors = ("q0", "w0", "q1", "w1", "trial", "change", "correction", "pull", "push", "row", "residual", "held")
    rows = 3 * points + nodes + tendons
    work = Scratch(
        before=empty_shape(layout), after=empty_shape(layout),
        paths_before=empty_paths(layout), paths_after=empty_paths(layout),
        rows=np.zeros(n, dtype=np.int64), force=np.zeros((points, 3)), velocity=np.zeros((points, 3)),
        spin=np.zeros(nodes), torque=np.zeros(nodes), taut=np.zeros(tendons), slack=np.zeros(tendons), scale=scale,
        unit=np.array([unit, 0.0, 0.0]), left=np.zeros(rows * width), right=np.zeros(rows * width),
        total=np.zeros(width**2), **{name: np.zeros((n, n)) for name in ("matrix", "elastic", "hessian")},
        **{name: np.zeros(n) for name in vectors},
    )  # fmt: skip
    return park(work)


@lean
def mass_matrix(layout: Layout, shape: Shape, out: Array) -> None:
    """Write the mass matrix of a shape, shape (n, n)."""
    n = len(layout.component)
    for a in range(n):
        for b in range(n):
            value = 0.0
            for j in range(len(layout.mass)):
                for i in range(3):
                    value += layout.mass[j] * shape.jacobian[j, i, a] * shape.jacobian[j, i, b]
            for k in range(1, len(layout.polar)):
                value += layout.polar[k] * shape.spin[k, a] * shape.spin[k, b]
            out[a, b] = value


@lean
def find_mass(layout: Layout, shape: Shape, work: Scratch, out: Array) -> None:
    """Write the mass matrix of a shape, shape (n, n), by sections: fast, with the scratch arrays."""
    n, width = len(layout.component), padded(len(layout.component))
    left, right, total, jacobian, spin = work.left, work.right, work.total, shape.jacobian, shape.spin
    left[:], right[:], total[:] = 0.0, 0.0, 0.0
    row = first = j = 0
    for k in range(1, len(layout.polar)):
        last, inertia = layout.last[k - 1], layout.polar[k]
        if inertia != 0.0:
            for a in range(last):
                left[row * width + a] = inertia * spin[k, a]
                right[row * width + a] = spin[k, a]
            row += 1
        while j < len(layout.mass) and layout.place[j] == k:
            m = layout.mass[j]
            for i in range(3):
                for a in range(last):
                    left[row * width + a] = m * jacobian[j, i, a]
                    right[row * width + a] = jacobian[j, i, a]
                row += 1
            j += 1
        if k + 1 == len(layout.polar) or layout.last[k] != last:
            add_products(left, right, width, first, row, 0, last, last, total)
            first = row
    for a in range(n):
        for b in range(n):
            out[a, b] = total[a * width + b]


@lean
def begin_step(layout: Layout, q0: Array, w0: Array, h: float, work: Scratch) -> None:
    """Write what a step of length h from (q0, w0) holds: `work.before` and its paths are at q0 already."""
    n = len(q0)
    jacobian, spin = work.before.jacobian, work.before.spin
    for j in range(len(layout.mass)):
        x = y = z = 0.0
        for a in range(layout.last[layout.place[j] - 1]):
            x += jacobian[j, 0, a] * w0[a]
            y += jacobian[j, 1, a] * w0[a]
            z += jacobian[j, 2, a] * w0[a]
        work.velocity[j, 0], work.velocity[j, 1], work.velocity[j, 2] = x, y, z
    for k in range(1, len(layout.polar)):
        rate = 0.0
        for a in range(layout.last[k - 1]):
            rate += spin[k, a] * w0[a]
        work.spin[k] = rate
    for a in range(n):
        work.held[a] = 0.0
    for b in range(n):
        for a in range(n):
            work.elastic[b, a] = (0.5 + DISSIPATION) * layout.stiffness[b, a] + layout.damping[b, a] / h
            work.held[a] += layout.stiffness[b, a] * q0[b]


@inlined
def _find_tensions(layout: Layout, loads: Loads, work: Scratch) -> None:
    """Write the mean tension of each tendon over a step [N], the work of its spring per displacement, and its slope."""
    for i in range(len(work.taut)):
        if loads.driven[i]:
            k = layout.tendon_stiffness[i]
            before = loads.tension[i] - work.paths_before.displacement[i]
            after = loads.tension[i] - work.paths_after.displacement[i]
            if before > 0.0 and after > 0.0:
                work.taut[i], work.slack[i] = 0.5 * k * (before + after), -0.5 * k
            elif before > 0.0:
                work.taut[i] = 0.5 * k * before * before / (before - after)
                work.slack[i] = -work.taut[i] / (before - after)
            elif after > 0.0:
                work.taut[i] = 0.5 * k * after * after / (after - before)
                work.slack[i] = -(k * after - work.taut[i]) / (after - before)
            else:
                work.taut[i] = work.slack[i] = 0.0
        else:
            work.taut[i], work.slack[i] = loads.tension[i], 0.0


@inlined
def _moved(one: Shape, two: Shape, j: int) -> Vector:
    """Return how far a mass point is from one shape to the other [m]."""
    a, b = one.point, two.point
    return b[j, 0] - a[j, 0], b[j, 1] - a[j, 1], b[j, 2] - a[j, 2]


@lean
def find_residual(layout: Layout, loads: Loads, q0: Array, q1: Array, h: float, work: Scratch) -> None:
    """Write the residual of a step that ends at q1, after `begin_step`."""
    n = len(q0)
    find_shape(layout, q1, work.after)
    if len(work.taut) > 0:
        find_paths(layout, q1, work.paths_after)
    _find_tensions(layout, loads, work)
    residual, change, pull = work.residual, work.change, work.pull
    one, two = work.before, work.after
    norm = lacking = 0.0
    for a in range(n):
        change[a] = q1[a] - q0[a]
        residual[a] = work.held[a]
        pull[a] = 0.0  # of all forces but the elastic ones
        norm += layout.stiffness[a, a] * change[a] * change[a]
    for b in range(n):
        for a in range(n):
            residual[a] += work.elastic[b, a] * change[b]
    for i in range(len(work.taut)):
        tension = 0.5 * work.taut[i]
        if tension != 0.0:
            lacking -= work.taut[i] * (work.paths_after.displacement[i] - work.paths_before.displacement[i])
            for a in range(n):
                pull[a] -= tension * (work.paths_before.gradient[i, a] + work.paths_after.gradient[i, a])
    for j in range(len(layout.mass)):
        m, k = layout.mass[j], layout.place[j]
        x, y, z = (
            (two.point[j, 0] - one.point[j, 0]),
            (two.point[j, 1] - one.point[j, 1]),
            (two.point[j, 2] - one.point[j, 2]),
        )
        factor = 2.0 * m / h
        fx = factor * (x / h - work.velocity[j, 0]) - m * layout.gravity[0] - loads.force[j, 0]
        fy = factor * (y / h - work.velocity[j, 1]) - m * layout.gravity[1] - loads.force[j, 1]
        fz = factor * (z / h - work.velocity[j, 2]) - m * layout.gravity[2] - loads.force[j, 2]
        for c in range(3):
            if layout.drag[j, c] != 0.0:
                rx = 0.5 * (one.rotation[k, c] + two.rotation[k, c])
                ry = 0.5 * (one.rotation[k, 3 + c] + two.rotation[k, 3 + c])
                rz = 0.5 * (one.rotation[k, 6 + c] + two.rotation[k, 6 + c])
                speed = (rx * x + ry * y + rz * z) / h
                drag = layout.drag[j, c] * speed * abs(speed)
                fx += drag * rx
                fy += drag * ry
                fz += drag * rz
        work.force[j, 0], work.force[j, 1], work.force[j, 2] = fx, fy, fz
        lacking += fx * x + fy * y + fz * z
        fx, fy, fz = 0.5 * fx, 0.5 * fy, 0.5 * fz
        for a in range(layout.last[k - 1]):
            pull[a] += (
                fx * (one.jacobian[j, 0, a] + two.jacobian[j, 0, a])
                + fy * (one.jacobian[j, 1, a] + two.jacobian[j, 1, a])
                + fz * (one.jacobian[j, 2, a] + two.jacobian[j, 2, a])
            )  # fmt: skip
    for a in range(n):
        residual[a] += pull[a]
        lacking -= pull[a] * change[a]
    for k in range(1, len(layout.polar)):
        last = layout.last[k - 1]
        if layout.polar[k] != 0.0:
            rate = 0.0
            for a in range(last):
                rate += (one.spin[k, a] + two.spin[k, a]) * change[a]
            torque = 2.0 * layout.polar[k] / h * (0.5 * rate / h - work.spin[k])
            work.torque[k] = torque
            for a in range(last):
                residual[a] += 0.5 * torque * (one.spin[k, a] + two.spin[k, a])
        x, y, z = 0.5 * loads.moment[k, 0], 0.5 * loads.moment[k, 1], 0.5 * loads.moment[k, 2]
        if x != 0.0 or y != 0.0 or z != 0.0:
            for a in range(last):
                residual[a] -= (
                    x * (one.twist[k, 0, a] + two.twist[k, 0, a]) + y * (one.twist[k, 1, a] + two.twist[k, 1, a])
                    + z * (one.twist[k, 2, a] + two.twist[k, 2, a])
                )  # fmt: skip
    norm += STILL * STILL * work.unit[0]
    share = lacking / norm
    for a in range(n):
        residual[a] += share * layout.stiffness[a, a] * change[a]
    work.unit[1], work.unit[2] = share, norm


@lean
def find_matrix(layout: Layout, loads: Loads, q1: Array, h: float, work: Scratch) -> None:
    """Write the derivative of the residual by q1, shape (n, n), after `find_residual` there."""
    n, width = len(q1), padded(len(q1))
    m, row, change, pull = work.matrix, work.row, work.change, work.pull
    one, two = work.before, work.after
    for a in range(n):
        row[a] = 0.0  # derivative of what the balance lacks
        for b in range(n):
            m[a, b] = 0.0
    curvature_of_points(layout, two, work.force, work.left, work.right, work.total, m)
    if len(work.taut) > 0:
        add_tendon_stiffness(layout, q1, work.taut, 1.0, work.paths_after, m)
    left, right, total = work.left, work.right, work.total
    left[:], right[:], total[:] = 0.0, 0.0, 0.0
    r = first = j = 0
    for k in range(1, len(layout.polar)):
        last = layout.last[k - 1]
        while j < len(layout.mass) and layout.place[j] == k:
            factor = 2.0 * layout.mass[j] / (h * h)
            x, y, z = _moved(one, two, j)
            xx = yy = zz = factor
            xy = yz = zx = 0.0
            for c in range(3):
                if layout.drag[j, c] != 0.0:
                    rx = 0.5 * (one.rotation[k, c] + two.rotation[k, c])
                    ry = 0.5 * (one.rotation[k, 3 + c] + two.rotation[k, 3 + c])
                    rz = 0.5 * (one.rotation[k, 6 + c] + two.rotation[k, 6 + c])
                    slope = 2.0 * layout.drag[j, c] * abs(rx * x + ry * y + rz * z) / (h * h)
                    xx += slope * rx * rx
                    yy += slope * ry * ry
                    zz += slope * rz * rz
                    xy += slope * rx * ry
                    yz += slope * ry * rz
                    zx += slope * rz * rx
            fx = work.force[j, 0] + xx * x + xy * y + zx * z
            fy = work.force[j, 1] + xy * x + yy * y + yz * z
            fz = work.force[j, 2] + zx * x + yz * y + zz * z
            p0, p1, p2 = r * width, (r + 1) * width, (r + 2) * width
            for b in range(last):
                jx, jy, jz = two.jacobian[j, 0, b], two.jacobian[j, 1, b], two.jacobian[j, 2, b]
                right[p0 + b], right[p1 + b], right[p2 + b] = jx, jy, jz
                row[b] += fx * jx + fy * jy + fz * jz
                jx = 0.5 * (jx + one.jacobian[j, 0, b])
                jy = 0.5 * (jy + one.jacobian[j, 1, b])
                jz = 0.5 * (jz + one.jacobian[j, 2, b])
                left[p0 + b] = xx * jx + xy * jy + zx * jz
                left[p1 + b] = xy * jx + yy * jy + yz * jz
                left[p2 + b] = zx * jx + yz * jy + zz * jz
            r += 3
            j += 1
        if k + 1 == len(layout.polar) or layout.last[k] != last:
            add_products(left, right, width, first, r, 0, last, last, total)
            first = r
    first = r
    for i in range(len(work.taut)):
        tension, slope = work.taut[i], work.slack[i]
        if tension != 0.0:
            way = work.paths_after.displacement[i] - work.paths_before.displacement[i]
            force = slope * way + tension
            for b in range(n):
                row[b] -= force * work.paths_after.gradient[i, b]
        if slope != 0.0:
            for b in range(n):
                right[r * width + b] = work.paths_after.gradient[i, b]
                left[r * width + b] = -0.5 * slope * (
                    work.paths_before.gradient[i, b] + work.paths_after.gradient[i, b]
                )  # fmt: skip
            r += 1
    if r > first:
        add_products(left, right, width, first, r, 0, n, n, total)
    share, norm = work.unit[1], work.unit[2]
    for b in range(n):
        row[b] -= pull[b] + 2.0 * share * layout.stiffness[b, b] * change[b]
    for a in range(n):
        for b in range(n):
            m[a, b] = 0.5 * m[a, b] + total[a * width + b]
            row[b] -= change[a] * m[a, b]
    total[:] = 0.0
    r = first = 0
    for k in range(1, len(layout.polar)):
        last, inertia = layout.last[k - 1], 0.5 * layout.polar[k] / (h * h)
        if inertia != 0.0:
            for a in range(last):
                both = one.spin[k, a] + two.spin[k, a]
                left[r * width + a], right[r * width + a] = inertia * both, both
            for a in range(last, width):
                left[r * width + a] = right[r * width + a] = 0.0
            r += 1
        if k + 1 == len(layout.polar) or layout.last[k] != last:
            add_products(left, right, width, first, r, 0, last, last, total)
            first = r
    for a in range(n):
        along = layout.stiffness[a, a] * change[a] / norm
        for b in range(n):
            m[a, b] += total[a * width + b] + work.elastic[a, b] + along * row[b]
        m[a, a] += share * layout.stiffness[a, a]
