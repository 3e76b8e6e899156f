"""Products of the rows of mass points and of intervals' ends, by sections: a row is 0 for the modes beyond it."""

from typing import Any

from tendond.model.numerics.compile import lean
from tendond.model.numerics.products import Lines, add_products, padded
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.layout import Layout


@lean
def add_point_rows(layout: Layout, left: Any, right: Any, out: Any) -> None:
    """Add the products of the rows of all mass points."""
    width, begin = padded(len(layout.component)), 0
    for j in range(len(layout.mass)):
        last = layout.last[layout.place[j] - 1]
        if j + 1 == len(layout.mass) or layout.last[layout.place[j + 1] - 1] != last:
            at, count, by = 3 * begin * width, 3 * (j + 1 - begin), (0, last)
            add_products(Lines(left, at, width), Lines(right, at, width), count, by, by, Lines(out, 0, width))
            begin = j + 1


@lean
def add_node_rows(layout: Layout, left: Any, right: Any, out: Any) -> None:
    """Add the products of the rows of all intervals' ends."""
    width, first, begin = padded(len(layout.component)), 3 * len(layout.mass), 0
    for k in range(len(layout.step)):
        last = layout.last[k]
        if k + 1 == len(layout.step) or layout.last[k + 1] != last:
            at, by = (first + begin) * width, (0, last)
            add_products(Lines(left, at, width), Lines(right, at, width), k + 1 - begin, by, by, Lines(out, 0, width))
            begin = k + 1


@lean
def add_all_points(layout: Layout, room: Room) -> None:
    """Add the products of the mass points' rows to the derivatives by q1, q0 and w0."""
    add_point_rows(layout, room.left, room.after, room.by_q1)
    add_point_rows(layout, room.left, room.before, room.by_q0)
    add_point_rows(layout, room.left, room.rate, room.by_w0)


@lean
def add_all_nodes(layout: Layout, room: Room) -> None:
    """Add the products of the intervals' ends to the derivatives by q1, q0 and w0."""
    add_node_rows(layout, room.left, room.after, room.by_q1)
    add_node_rows(layout, room.left, room.before, room.by_q0)
    add_node_rows(layout, room.left, room.rate, room.by_w0)
