"""Tension along an elastic tendon on its guides, by Coulomb's law: a chain of cells with a contact before each.

Cell i with the compliance c_i has the tension T_i and the length of path l_i. Contact i, before it, slides by y_i, and
nothing slides at the tendon's end, so that c_i (T_i - T_i0) = y_i - y_(i+1) + l_i - l_i0 over a step. It sticks where
the ratio of the tensions at it is within e^(mu phi) of 1, phi the bend of the path there; it slides towards the servo
where T_i = e^(-mu phi) T_(i-1), towards the tip where T_i = e^(mu phi) T_(i-1) (Euler 1769, Eytelwein 1808).

Such chains are solved exactly. The slip y_i that cell i needs is a function of its tension T alone,

    Y_i(T) = c_i (T - T_i0) - (l_i - l_i0) + max(0, Y_(i+1)(e^(-mu phi) T)) + min(0, Y_(i+1)(e^(mu phi) T)),

which grows with T; at its root the contact before the cell sticks. From the roots of all cells, found from the tip on,
the tensions follow from the servo on: each is its cell's root, moved into the cone of the tension before it. For a path
that keeps its length the roots are the tensions before the step, and what is left is T := clip(T, T_0 e^(-mu theta),
T_0 e^(mu theta)).
"""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.strain.friction.grip import Grip
from tendond.model.strain.layout import Layout

ITERATIONS = 60
"""Newton's iterations for a piecewise linear function of one number, bounded from both sides: it takes one a piece."""

ROUNDING = 1e-14
"""Part of a tension that is lost in rounding."""

STILL = 1e-12
"""Part of the tendon's length by which its end has moved that is lost in rounding."""


@inlined
def _stretch(layout: Layout, grip: Grip, f: int, i: int, tension: float, held: bool) -> float:
    """Return by how much less than its tension asks for cell i has been lengthened by its path [m]."""
    value: float = layout.compliance[i, grip.tendon[f]] * (tension - grip.start[f, 1 + i])
    if held:
        value += grip.after.shortening[f, i] - grip.before.shortening[f, i]
    return value


@inlined
def _find_slip(layout: Layout, grip: Grip, f: int, begin: int, tension: float, held: bool) -> tuple[float, float]:
    """Return the slip of the contact before a cell for its tension [m], and its derivative [m/N]."""
    slip = slope = 0.0
    factor = 1.0
    for i in range(begin, grip.number[f]):
        slip += _stretch(layout, grip, f, i, tension, held)
        slope += factor * layout.compliance[i, grip.tendon[f]]
        if i + 1 < grip.number[f]:
            ratio, stuck = grip.ratio[f, i + 1], grip.stuck[i + 1]
            if ratio * tension > stuck:
                tension, factor = ratio * tension, ratio * factor
            elif tension < ratio * stuck:
                tension, factor = tension / ratio, factor / ratio
            elif layout.hole[i + 1, grip.tendon[f]] == i + 1:
                break
    return slip, slope


@inlined
def _find_tension(layout: Layout, grip: Grip, f: int, i: int, slip: float, held: bool) -> float:
    """Return the tension of a cell for which the contact before it slips so far [N]; 0 where it is slack."""
    low, high = -1.0, -1.0
    tension: float = grip.start[f, 1 + i]
    for _ in range(ITERATIONS):
        found, slope = _find_slip(layout, grip, f, i, tension, held)
        if found > slip:
            high = tension
        else:
            low = tension
        trial = tension - (found - slip) / slope
        if abs(trial - tension) <= ROUNDING * (tension + grip.start[f, 1 + i]):
            return float(trial)
        if trial <= 0.0 and low < 0.0:
            found, _ = _find_slip(layout, grip, f, i, 0.0, held)
            if found >= slip:
                return 0.0
            low = 0.0
        if trial < low or (high >= 0.0 and trial > high):
            trial = 0.5 * (low + high) if high >= 0.0 else low
        tension = trial
    return tension


@inlined
def _close(layout: Layout, grip: Grip, f: int, held: bool) -> None:
    """Write the tensions behind the first cell, from there on, and add friction's work."""
    count, tension = grip.number[f], grip.tension[f]
    for i in range(1, count):
        ratio, before, stuck = grip.ratio[f, i], tension[i], grip.stuck[i]
        if ratio * before > stuck:
            tension[1 + i], grip.slid[f, i] = ratio * before, 1
        elif before < ratio * stuck:
            tension[1 + i], grip.slid[f, i] = before / ratio, -1
        else:
            sticks = layout.hole[i, grip.tendon[f]] == i
            tension[1 + i], grip.slid[f, i] = stuck, 0 if sticks else 1
    slip = 0.0
    for i in range(count - 1, -1, -1):
        slip += _stretch(layout, grip, f, i, tension[1 + i], held)
        if grip.slid[f, i] != 0:
            grip.lost[0] += slip * (tension[i] - tension[1 + i])


@inlined
def _slacken(grip: Grip, f: int) -> None:
    """Write that a tendon is slack."""
    grip.tension[f, :] = 0.0
    grip.slid[f, :] = 1


@inlined
def _find_stuck(layout: Layout, grip: Grip, f: int, held: bool) -> None:
    """Write the tensions at which the contacts would stick, from the tip on."""
    for i in range(grip.number[f] - 1, -1, -1):
        grip.stuck[i] = _find_tension(layout, grip, f, i, 0.0, held)


@lean
def pull_tendon(layout: Layout, grip: Grip, f: int, pull: float) -> None:
    """Write the tensions along a tendon whose servo's end is pulled with a force [N]; see the module."""
    if pull <= 0.0:
        _slacken(grip, f)
        return
    _find_stuck(layout, grip, f, True)
    ratio, stuck, tension = grip.ratio[f, 0], grip.stuck[0], grip.tension[f]
    tension[0] = pull
    if ratio * pull > stuck:
        tension[1], grip.slid[f, 0] = ratio * pull, 1
    elif pull < ratio * stuck:
        tension[1], grip.slid[f, 0] = pull / ratio, -1
    else:
        tension[1], grip.slid[f, 0] = stuck, 0
    _close(layout, grip, f, True)


@lean
def move_tendon(layout: Layout, grip: Grip, f: int, displacement: float, before: float, after: float) -> None:
    """Write the tensions along a tendon whose servo's end is moved to a displacement [m].

    Args:
        layout: of the robot.
        grip: with the cells of both shapes, and the bends.
        f: number of the tendon, of those that rub.
        displacement: of its end [m].
        before: shortening of its path before the step [m].
        after: the same after it [m].
    """
    if displacement <= after:
        _slacken(grip, f)
        return
    tension, length, stretch = grip.tension[f], 0.0, 0.0
    for i in range(grip.number[f]):
        stretch += layout.compliance[i, grip.tendon[f]] * grip.start[f, 1 + i]
        length += layout.weight[i, grip.tendon[f]]
    held = stretch > 0.0  # a slack tendon is where nothing holds it, and taut anew it has no history
    moved = displacement - before - stretch if held else displacement - after
    _find_stuck(layout, grip, f, held)
    ratio = grip.ratio[f, 0]
    if abs(moved) <= STILL * length:
        tension[1], grip.slid[f, 0] = grip.stuck[0], 0
        tension[0] = min(max(grip.start[f, 0], ratio * tension[1]), tension[1] / ratio)
    else:
        tension[1] = _find_tension(layout, grip, f, 0, moved, held)
        grip.slid[f, 0] = 1 if moved > 0.0 else -1
        tension[0] = tension[1] / ratio if moved > 0.0 else tension[1] * ratio
    _close(layout, grip, f, held)


@lean
def find_slopes(layout: Layout, grip: Grip, f: int, n: int) -> None:
    """Write the derivatives of the tensions by the n modes.

    Between two contacts that stick the cells' lengths add up to what they were; contacts in between slide.
    """
    i, mu, slope = 0, layout.friction[grip.tendon[f]], grip.slope[f]
    if grip.tension[f, 0] <= 0.0:
        slope[:, :] = 0.0
        return
    while i < grip.number[f]:
        free = i == 0 and grip.driven[f] == 0 and grip.slid[f, 0] != 0  # pulled with a given force
        grip.share[i], end = 1.0, i + 1
        for a in range(n):
            slope[i, a] = -grip.slid[f, 0] * mu * grip.tension[f, 1] * grip.turn[f, 0, a] if free else 0.0
        while end < grip.number[f] and grip.slid[f, end] != 0:
            factor = _factor(grip, f, end)
            along = grip.slid[f, end] * mu * grip.tension[f, 1 + end]
            grip.share[end] = factor * grip.share[end - 1]
            for a in range(n):
                slope[end, a] = factor * slope[end - 1, a] - along * grip.turn[f, end, a]
            end += 1
        if not free:
            whole = 0.0
            for j in range(i, end):
                whole += layout.compliance[j, grip.tendon[f]] * grip.share[j]
            for a in range(n):
                lacking = 0.0
                for j in range(i, end):
                    lacking += layout.compliance[j, grip.tendon[f]] * slope[j, a] + grip.after.gradient[f, j, a]
                for j in range(i, end):
                    slope[j, a] -= grip.share[j] * lacking / whole
        i = end


@inlined
def _factor(grip: Any, f: int, i: int) -> float:
    """Return the ratio of the tensions behind and before a contact that slides."""
    value: float = grip.ratio[f, i] if grip.slid[f, i] > 0 else 1.0 / grip.ratio[f, i]
    return value
