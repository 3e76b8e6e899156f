"""All onsets and places at once: a pass back in time over the last cycles, and one forth for the likeliest.

The pass back is the smoother of disturbances, which has the score and the information of a shock at each time (P. de
Jong, J. Penzer, "Diagnosing shocks in time series", J. Am. Stat. Assoc. 93, 1998). With a force that lasts, they are
sums over all later times; with the transition A, the response B, and phi = I - K C, for the errors before time t

    r- = phi' r+ + C' S^-1 nu,    M- = phi' M+ phi + C' S^-1 C,    Y- = phi' Y+,
    r+(t-1) = A' r-,    M+(t-1) = A' M- A,    Y+(t-1) = A' (Y- + M- B),

score and information of a force from t on grow by B' r- and B' M- B + B' Y- + Y-' B. A force that begins within a step
acts for a part of it.
"""

from typing import Any

from tendond.model.estimation.contact.signatures import solve_three
from tendond.model.numerics.compile import lean

PARTS = 4
"""Onsets within a step that are tried: it acts for 0, 1/4, 2/4 or 3/4 of it."""


@lean
def measure_back(white: Any, gain: Any, innovation: Any, r: Any, m: Any, y: Any, room: Any) -> None:
    """Go back over a measurement: r, M and Y of the errors before it, by those after it, in place.

    Args:
        white, gain, innovation: of unit variance, see `signatures.whiten`.
        r: shape (N,). m: shape (N, N). y: shape (N, 3 p). room: shape (2 q, max(q, N, 3 p)), for q numbers.
    """
    n, columns, q = len(r), y.shape[1], len(innovation)
    for a in range(q):
        value = innovation[a]
        for i in range(n):
            value -= gain[a, i] * r[i]
        room[q + a, 0] = value
        for c in range(columns):
            room[a, c] = 0.0
        for i in range(n):
            part = gain[a, i]
            for c in range(columns):
                room[a, c] += part * y[i, c]
    for a in range(q):
        for i in range(n):
            part = white[a, i]
            r[i] += part * room[q + a, 0]
            for c in range(columns):
                y[i, c] -= part * room[a, c]
    for a in range(q):  # room = K' M, then half of what it adds along C
        for j in range(n):
            room[a, j] = 0.0
        for i in range(n):
            part = gain[a, i]
            for j in range(n):
                room[a, j] += part * m[i, j]
    for a in range(q):
        for b in range(q):
            value = 1.0 if a == b else 0.0
            for i in range(n):
                value += room[a, i] * gain[b, i]
            room[q + a, b] = value
    for a in range(q):
        for b in range(q):
            part = 0.5 * room[q + a, b]
            for j in range(n):
                room[a, j] -= part * white[b, j]
    for a in range(q):
        for i in range(n):
            one, two = white[a, i], room[a, i]
            for j in range(n):
                m[i, j] -= one * room[a, j] + two * white[a, j]


@lean
def step_back(top: Any, decay: Any, push: Any, r: Any, m: Any, y: Any, pushed: Any, room: Any) -> None:
    """Go back over a step, in place.

    Args:
        top, decay: of A, see `signatures.carry`. push: B, shape (2 k, 3 p).
        r: shape (N,). m: shape (N, N). y: shape (N, 3 p). pushed: M- B, shape (N, 3 p). room: shape (N, N).
    """
    n, columns, t = len(r), y.shape[1], len(top)
    for i in range(n):
        for c in range(columns):
            y[i, c] += pushed[i, c]
    for i in range(n):  # room = M A
        for j in range(n):
            room[i, j] = m[i, j] * decay[j - t] if j >= t else 0.0
        for l in range(t):
            part = m[i, l]
            for j in range(n):
                room[i, j] += part * top[l, j]
    for i in range(n):  # M = A' room
        part = decay[i - t] if i >= t else 0.0
        for j in range(n):
            m[i, j] = part * room[i, j]
    for l in range(t):
        for i in range(n):
            part = top[l, i]
            for j in range(n):
                m[i, j] += part * room[l, j]
    for c in range(columns):  # the lower rows before the upper ones, which they need
        for i in range(t, n):
            y[i, c] *= decay[i - t]
    for i in range(t, n):
        r[i] *= decay[i - t]
        for l in range(t):
            r[i] += top[l, i] * r[l]
            part = top[l, i]
            for c in range(columns):
                y[i, c] += part * y[l, c]
    for i in range(t):
        for c in range(columns):
            room[i, c] = 0.0
        room[t, i] = 0.0
        for l in range(t):
            part = top[l, i]
            room[t, i] += part * r[l]
            for c in range(columns):
                room[i, c] += part * y[l, c]
    for i in range(t):
        r[i] = room[t, i]
        for c in range(columns):
            y[i, c] = room[i, c]


@lean
def gather(push: Any, r: Any, m: Any, y: Any, pushed: Any, score: Any, information: Any) -> None:
    """Write what a force within a step adds to score and information: of the step alone, and with those after it.

    Args:
        push: B, shape (2 k, 3 p). r, m, y: of the errors after the step, before the measurement there.
        pushed: takes M- B, shape (N, 3 p). score: takes B' r-, shape (p, 3).
        information: takes B' M- B, and B' Y- + Y-' B, shape (2, p, 3, 3).
    """
    n, columns, t = len(r), y.shape[1], len(push)
    for i in range(n):
        for c in range(columns):
            pushed[i, c] = 0.0
        for l in range(t):
            part = m[i, l]
            for c in range(columns):
                pushed[i, c] += part * push[l, c]
    for p in range(columns // 3):
        for a in range(3):
            total = 0.0
            for i in range(t):
                total += push[i, 3 * p + a] * r[i]
            score[p, a] = total
            for b in range(3):
                alone, crossed = 0.0, 0.0
                for i in range(t):
                    alone += push[i, 3 * p + a] * pushed[i, 3 * p + b]
                    crossed += push[i, 3 * p + a] * y[i, 3 * p + b] + y[i, 3 * p + a] * push[i, 3 * p + b]
                information[0, p, a, b] = alone
                information[1, p, a, b] = crossed


@lean
def weigh_onsets(
    score: Any, information: Any, step_score: Any, step_information: Any, prior: Any, room: Any, tick: int, force: Any,
    statistic: Any, onset: Any,
) -> None:  # fmt: skip
    """Keep, for each place, the likeliest of the onsets within a step, and those after it that were weighed before.

    Args:
        score, information: of a force from the next step on, shapes (p, 3) and (p, 3, 3).
        step_score, step_information: see `gather`. prior: information beforehand, shape (p, 3, 3) [1/N^2].
        room: shape (5, 3). tick: at the end of the step.
        force: the likeliest, shape (p, 3) [N]. statistic: shape (p,). onset: shape (p,), in ticks.
    """
    for p in range(len(statistic)):
        for part in range(PARTS):
            share = part / PARTS
            for a in range(3):
                room[3, a] = score[p, a] + share * step_score[p, a]
                for b in range(3):
                    room[a, b] = (
                        prior[p, a, b]
                        + information[p, a, b]
                        + share * (share * step_information[0, p, a, b] + step_information[1, p, a, b])
                    )
            value = solve_three(room[:3], room[3], room[4])
            if value > statistic[p]:
                statistic[p], onset[p] = value, tick - share
                for a in range(3):
                    force[p, a] = room[4, a]
