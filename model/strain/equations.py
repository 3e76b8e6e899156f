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

from tendond.model.numerics.compile import inlined, kernel
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


def scratch_for(layout: Layout) -> Scratch:
    """Return arrays for the steps of this robot."""
    n, points, tendons, nodes = len(layout.component), len(layout.mass), len(layout.straight), len(layout.polar)
    lengths = np.zeros(n)
    for first, last, step in zip(layout.first, layout.last, layout.step, strict=True):
        lengths[first:last] += step
    scale = np.where(layout.component < STRETCH - 2, lengths**2, 1.0) / (2.0 * layout.order + 1.0)
    bends = (layout.component <= BENDING_Y) & (layout.order == 0)
    unit = np.min(np.diag(layout.stiffness)[bends] / lengths[bends] ** 2)
    return Scratch(
        empty_shape(layout), empty_shape(layout), empty_paths(layout), empty_paths(layout), np.zeros((n, n)),
        np.zeros(n, dtype=np.int64), np.zeros(n), np.zeros((points, 3)), np.zeros((points, 3)), np.zeros(nodes),
        np.zeros(nodes), np.zeros(tendons), np.zeros(tendons), np.zeros((n, n)), np.zeros(n), scale,
        np.array([unit, 0.0, 0.0]), *np.zeros((10, n)), np.zeros((n, n)),  # type: ignore[call-arg]
    )  # fmt: skip


@kernel
def mass_matrix(layout: Layout, shape: Shape, out: Array) -> None:
    """Write the mass matrix of a shape, shape (n, n)."""
    n = len(layout.component)
    jacobian, spin = shape.jacobian, shape.spin
    for a in range(n):
        for b in range(n):
            out[a, b] = 0.0
    for j in range(len(layout.mass)):
        m, last = layout.mass[j], layout.last[layout.place[j] - 1]
        for a in range(last):
            x, y, z = m * jacobian[j, 0, a], m * jacobian[j, 1, a], m * jacobian[j, 2, a]
            for b in range(a, last):
                out[a, b] += x * jacobian[j, 0, b] + y * jacobian[j, 1, b] + z * jacobian[j, 2, b]
    for k in range(1, len(layout.polar)):
        inertia, last = layout.polar[k], layout.last[k - 1]
        if inertia != 0.0:
            for a in range(last):
                turned = inertia * spin[k, a]
                for b in range(a, last):
                    out[a, b] += turned * spin[k, b]
    for a in range(n):
        for b in range(a):
            out[a, b] = out[b, a]


@kernel
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


@kernel
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


@kernel
def find_matrix(layout: Layout, loads: Loads, q1: Array, h: float, work: Scratch) -> None:
    """Write the derivative of the residual by q1, shape (n, n), after `find_residual` there."""
    n = len(q1)
    m, row, change, pull = work.matrix, work.row, work.change, work.pull
    one, two = work.before, work.after
    for a in range(n):
        row[a] = 0.0  # derivative of what the balance lacks
        for b in range(n):
            m[a, b] = 0.0
    curvature_of_points(layout, two, work.force, m)
    if len(work.taut) > 0:
        add_tendon_stiffness(layout, q1, work.taut, 1.0, work.paths_after, m)
    for a in range(n):
        for b in range(n):
            m[a, b] *= 0.5
    for j in range(len(layout.mass)):
        k, factor = layout.place[j], 2.0 * layout.mass[j] / (h * h)
        last = layout.last[k - 1]
        for a in range(last):
            x = 0.5 * factor * (one.jacobian[j, 0, a] + two.jacobian[j, 0, a])
            y = 0.5 * factor * (one.jacobian[j, 1, a] + two.jacobian[j, 1, a])
            z = 0.5 * factor * (one.jacobian[j, 2, a] + two.jacobian[j, 2, a])
            for b in range(last):
                m[a, b] += x * two.jacobian[j, 0, b] + y * two.jacobian[j, 1, b] + z * two.jacobian[j, 2, b]
        x, y, z = (
            (two.point[j, 0] - one.point[j, 0]),
            (two.point[j, 1] - one.point[j, 1]),
            (two.point[j, 2] - one.point[j, 2]),
        )
        fx, fy, fz = work.force[j, 0] + factor * x, work.force[j, 1] + factor * y, work.force[j, 2] + factor * z
        for c in range(3):
            if layout.drag[j, c] != 0.0:
                rx = 0.5 * (one.rotation[k, c] + two.rotation[k, c])
                ry = 0.5 * (one.rotation[k, 3 + c] + two.rotation[k, 3 + c])
                rz = 0.5 * (one.rotation[k, 6 + c] + two.rotation[k, 6 + c])
                along = rx * x + ry * y + rz * z
                slope = 2.0 * layout.drag[j, c] * abs(along) / (h * h)
                fx += slope * along * rx
                fy += slope * along * ry
                fz += slope * along * rz
                for a in range(last):
                    left = 0.5 * slope * (
                        rx * (one.jacobian[j, 0, a] + two.jacobian[j, 0, a])
                        + ry * (one.jacobian[j, 1, a] + two.jacobian[j, 1, a])
                        + rz * (one.jacobian[j, 2, a] + two.jacobian[j, 2, a])
                    )  # fmt: skip
                    for b in range(last):
                        m[a, b] += left * (
                            rx * two.jacobian[j, 0, b] + ry * two.jacobian[j, 1, b] + rz * two.jacobian[j, 2, b]
                        )
        for b in range(last):
            row[b] += fx * two.jacobian[j, 0, b] + fy * two.jacobian[j, 1, b] + fz * two.jacobian[j, 2, b]
    for i in range(len(work.taut)):
        tension, slope = work.taut[i], work.slack[i]
        if tension != 0.0:
            way = work.paths_after.displacement[i] - work.paths_before.displacement[i]
            total = slope * way + tension
            for b in range(n):
                row[b] -= total * work.paths_after.gradient[i, b]
        if slope != 0.0:
            for a in range(n):
                left = -0.5 * slope * (work.paths_before.gradient[i, a] + work.paths_after.gradient[i, a])
                for b in range(n):
                    m[a, b] += left * work.paths_after.gradient[i, b]
    share, norm = work.unit[1], work.unit[2]
    for b in range(n):
        row[b] -= pull[b] + 2.0 * share * layout.stiffness[b, b] * change[b]
    for a in range(n):
        for b in range(n):
            row[b] -= change[a] * m[a, b]
    for k in range(1, len(layout.polar)):
        last = layout.last[k - 1]
        if layout.polar[k] != 0.0:
            for a in range(last):
                left = 0.5 * layout.polar[k] / (h * h) * (one.spin[k, a] + two.spin[k, a])
                for b in range(last):
                    m[a, b] += left * (one.spin[k, b] + two.spin[k, b])
    for a in range(n):
        left = layout.stiffness[a, a] * change[a] / norm
        for b in range(n):
            m[a, b] += work.elastic[a, b] + left * row[b]
        m[a, a] += share * layout.stiffness[a, a]
