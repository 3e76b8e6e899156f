"""Inertia of the nodes about their own axes in the derivative of a step's balance, section by section from the tip.

It is symmetric, and does no work that the balance counts.
"""

from tendond.model.numerics.compile import lean
from tendond.model.numerics.products import BLOCK, HALF, Lines, add_products, padded
from tendond.model.numerics.simd import simd_load, simd_store
from tendond.model.strain.composites import add_moved, add_three, own_lanes, own_six
from tendond.model.strain.kinematics import axis_of
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Scratch
from tendond.model.strain.twists import store_six


@lean
def add_spins(layout: Layout, h: float, work: Scratch) -> None:
    """Write what inertia about the nodes' own axes does to the derivative of the balance to `work.spun`."""
    width, one, two, spans = padded(len(work.q1)), work.before, work.after, work.after.spans
    stride, narrow, left, right = two.spin.shape[1], spans.width[0], work.left, work.right
    apart, pushes, spun = work.apart, work.pushes, work.spun
    spun[:] = 0.0
    apart[:] = 0.0
    for s in range(len(spans.first) - 1, -1, -1):
        base, end, block, first, last = spans.node[s], spans.node[s + 1], spans.block[s], spans.first[s], spans.last[s]
        pushes[:] = 0.0
        row = 0
        for k in range(base + 1, end + 1):
            inertia, a0, a1 = 0.5 * layout.polar[k] / (h * h), axis_of(one, k, 2), axis_of(two, k, 2)
            if inertia == 0.0:
                continue
            for b in range(block, last, HALF):
                both = simd_load(one.spins, k * stride + b, BLOCK) + simd_load(two.spins, k * stride + b, BLOCK)
                both = both * own_lanes(spans, s, b)
                push = inertia * both
                simd_store(left, row * narrow + b - block, push)
                simd_store(right, row * narrow + b - block, both)
                if first > 0:
                    add_three(pushes, b - block, narrow, (push * a0[0], push * a0[1], push * a0[2]))
                    add_three(pushes, b - block + 3 * narrow, narrow, (push * a1[0], push * a1[1], push * a1[2]))
            row += 1
        if s + 1 < len(spans.first):
            for b in range(block, last, HALF):
                own, to = own_lanes(spans, s, b), b - block
                six = own_six(one, end, b, own)[0], own_six(two, end, b, own)[0]
                store_six(left, row * narrow + to, narrow, six)
                for r in range(6):
                    simd_store(right, (row + r) * narrow + to, own * 0.0)
                add_moved(apart, 0, six, right, row * narrow + to, narrow)
                if first > 0:
                    add_moved(apart, 0, six, pushes, to, narrow)
            row += 6
        by = (0, last - block)
        add_products(
            Lines(left, 0, narrow), Lines(right, 0, narrow), row, (first - block, last - block), by,
            Lines(spun, block * width + block, width),
        )  # fmt: skip
        if first > 0:
            at, here = 6 * base * stride, Lines(spun, block, width)
            below = Lines(pushes, 3 * narrow, narrow)
            add_products(Lines(one.twists, at, stride), Lines(pushes, 0, narrow), 3, (0, first), by, here)
            add_products(Lines(two.twists, at, stride), below, 3, (0, first), by, here)
            for k in range(base + 1, end + 1):
                inertia, a0, a1 = 0.5 * layout.polar[k] / (h * h), axis_of(one, k, 2), axis_of(two, k, 2)
                for r in range(3):
                    for c in range(3):
                        apart[6 * r + c] += inertia * a0[r] * a0[c]
                        apart[6 * r + 3 + c] += inertia * a0[r] * a1[c]
                        apart[6 * r + 18 + c] += inertia * a1[r] * a0[c]
                        apart[6 * r + 21 + c] += inertia * a1[r] * a1[c]
    for a in range(len(work.q1)):
        for b in range(a):
            spun[a * width + b] = spun[b * width + a]
