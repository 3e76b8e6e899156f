"""Time steps of the strain rod that never fail: Newton's method on the balance, shorter steps, and a minimum last.

Where Newton's method comes to no end, the step is halved, and parts that are too violent all the same are taken as
implicit Euler steps, which are minima of an energy and always exist; they take energy away, are first-order in time,
and are counted.

The rates after a step are those of the modes nearest to the points' velocities, in the mass metric, which takes energy
away, and gives none.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import factor_symmetric, solve_symmetric
from tendond.model.numerics.products import padded
from tendond.model.strain.friction.pulls import accept_friction, begin_friction, find_friction
from tendond.model.strain.friction.solve import solve_rubbing
from tendond.model.strain.kinematics import find_shape, point_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.minima.energy import find_energy
from tendond.model.strain.minima.minimise import minimise
from tendond.model.strain.stepping.balance import begin_step
from tendond.model.strain.stepping.carried import AFTER, TURN, carried_spin, carried_velocity, is_moving, place_base
from tendond.model.strain.stepping.mass import find_mass
from tendond.model.strain.stepping.newton import solve_step
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendons import find_paths

Array = NDArray[np.float64]

SPLITS = 3
"""Halvings of a step at most, before implicit Euler steps take over."""


@lean
def project_rates(layout: Layout, old: float, new: float, work: Scratch) -> float:
    """Write to `work.w1` the rates nearest to the points' velocities; return twice their kinetic energy [J].

    The velocities are `new` (x1 - x0) - `old` v0: 2 / h and 1 for the balanced step, 1 / h and 0 for implicit Euler's.
    """
    n, width = len(work.q1), padded(len(work.q1))
    w1, one, two, moving = work.w1, work.before, work.after, is_moving(work)
    find_mass(layout, two, work)
    for a in range(n):
        w1[a] = 0.0
    for j in range(len(layout.mass)):
        m, k = layout.mass[j], layout.place[j]
        x = m * (new * (two.point[j, 0] - one.point[j, 0]) - old * work.velocity[j, 0])
        y = m * (new * (two.point[j, 1] - one.point[j, 1]) - old * work.velocity[j, 1])
        z = m * (new * (two.point[j, 2] - one.point[j, 2]) - old * work.velocity[j, 2])
        if moving:
            vx, vy, vz = carried_velocity(work, two, AFTER, point_of(two.point, j))
            x, y, z = x - m * vx, y - m * vy, z - m * vz
        for a in range(layout.last[k - 1]):
            w1[a] += x * two.jacobian[j, 0, a] + y * two.jacobian[j, 1, a] + z * two.jacobian[j, 2, a]
    for k in range(1, len(layout.polar)):
        if layout.polar[k] != 0.0:
            last = layout.last[k - 1]
            rate = 0.0
            for a in range(last):
                rate += 0.5 * (one.spin[k, a] + two.spin[k, a]) * (work.q1[a] - work.q0[a])
            turned = new * rate - old * work.spin[k]
            if moving:
                turned += 0.5 * new * (carried_spin(work, one, TURN, k) + carried_spin(work, two, TURN, k))
                turned -= carried_spin(work, two, AFTER + 3, k)
            turned *= layout.polar[k]
            for a in range(last):
                w1[a] += turned * two.spin[k, a]
    for a in range(n):
        work.row[a] = w1[a]
    if not factor_symmetric(work.mass, n, width):
        return -1.0
    solve_symmetric(work.mass, w1, n, width, work.solving)
    twice = 0.0
    for a in range(n):
        twice += work.row[a] * w1[a]
    return twice


@lean
def damped_step(layout: Layout, loads: Loads, h: float, tolerance: float, work: Scratch) -> int:
    """Take an implicit Euler step from `work.q0` to `work.q1`, after `begin_step`; return Newton's iterations.

    It is the minimum of an energy, the least that was found if Newton's method ends early: whatever comes out, the
    potential energy after it is not above all energy before it, and the rates are scaled so that the sum is not either.
    """
    n = len(work.q0)
    for a in range(n):
        work.q1[a] = work.q0[a]
    before, _ = find_energy(layout, loads, work.q1, 1.0 / h, work)  # at q0: potential and kinetic energy
    count = minimise(layout, loads, work.q1, 1.0 / h, tolerance, work)
    after, _ = find_energy(layout, loads, work.q1, 1.0 / h, work)
    inertia = 0.0  # what the minimum has above the potential energy, and lets go
    one, two = work.before, work.after
    for j in range(len(layout.mass)):
        for c in range(3):
            v = (two.point[j, c] - one.point[j, c]) / h - work.velocity[j, c]
            inertia += 0.5 * layout.mass[j] * v * v
    for k in range(1, len(layout.polar)):
        turned = 0.0
        for a in range(layout.last[k - 1]):
            turned += one.spin[k, a] * (work.q1[a] - work.q0[a])
        turned = turned / h - work.spin[k]
        inertia += 0.5 * layout.polar[k] * turned * turned
    twice = project_rates(layout, 0.0, 1.0 / h, work)
    allowed = max(0.0, 2.0 * (before - after + inertia))
    if not (is_moving(work) or twice <= allowed):  # a base that moves may put in any energy
        factor = np.sqrt(allowed / twice) if twice > 0.0 else 0.0
        for a in range(n):
            work.w1[a] *= factor
    return int(abs(count))


@lean
def advance(
    layout: Layout, loads: Loads, q: Array, w: Array, h: float, tolerance: float, work: Scratch, known: bool
) -> tuple[int, int, int]:
    """Advance q and w by the time h, in place: one step, or, where that does not converge, as many shorter ones.

    Args:
        layout: of the robot.
        loads: on it, held over the step.
        q: strains, shape (n,).
        w: their rates [1/s], shape (n,).
        h: [s].
        tolerance: of the strains [rad], in the measure of energy.
        work: scratch arrays; `after` is at q when it returns. `trend`: see `trend_of`, or zeros.
        known: whether `before` is at q already, as the `after` of the step that led here: see `mirrored`.

    Returns:
        Residuals and iterations of all steps; the number of steps; how many of these were implicit Euler's.
    """
    n = len(q)
    q0, w0, q1 = work.q0, work.w0, work.q1
    total = steps = damped = done = 0
    moving, rubbing = is_moving(work), len(work.grip.tendon) > 0
    whole = 1 << SPLITS
    part = whole
    for a in range(n):
        known = known and q[a] == q1[a]
        q0[a], w0[a] = q[a], w[a]
    while done < whole:
        if moving:
            place_base(work, h * done / whole, h * (done + part) / whole)
        if not known:
            find_shape(layout, q0, work.before)
            if len(work.taut) > 0:
                find_paths(layout, q0, work.paths_before)
        known = False
        if rubbing:
            begin_friction(layout, work)
        while True:
            length = h * part / whole
            if moving:
                place_base(work, h * done / whole, h * (done + part) / whole)
            begin_step(layout, q0, w0, length, work)
            for a in range(n):
                q1[a] = q0[a] + length * w0[a]
            if steps == 0 and part == whole:
                for a in range(n):
                    q1[a] += length * work.trend[a]
            if rubbing:
                count = solve_rubbing(layout, loads, length, tolerance, work)
            else:
                count = solve_step(layout, loads, length, tolerance, work)
            if count > 0:
                twice = project_rates(layout, 1.0, 2.0 / length, work)
                if twice >= 0.0:
                    break
            if part > 1:
                part //= 2
                continue
            count = damped_step(layout, loads, length, tolerance, work)
            damped += 1
            if rubbing:
                find_friction(layout, loads, q1, work)
            break
        if rubbing:
            accept_friction(work)
        total += count
        steps += 1
        done += part
        for a in range(n):
            q0[a], w0[a] = q1[a], work.w1[a]
        while 2 * part <= whole - done and done % (2 * part) == 0:
            part *= 2
    for a in range(n):
        q[a], w[a] = q0[a], w0[a]
    return total, steps, damped
