"""Nodes of a robot by their arc lengths."""

import numpy as np

from tendond.model.errors import ParameterError
from tendond.model.strain.layout import Layout


class Places:
    """Places at which loads may act.

    Args:
        layout: of the robot.
    """

    def __init__(self, layout: Layout) -> None:
        self._nodes = np.concatenate(([0.0], np.cumsum(layout.step)))  # arc lengths
        self._middles = 0.5 * (self._nodes[1:] + self._nodes[:-1])
        self._points = np.full(len(self._nodes), -1)  # mass point on the backbone at each node
        on_axis = np.flatnonzero(~layout.arm.any(axis=1))[::-1]  # the first one of a node counts
        self._points[layout.place[on_axis]] = on_axis

    def node(self, at: float) -> tuple[int, int]:
        """Return the node at an arc length [m], and the mass point on the backbone there.

        Raises:
            ParameterError: there is none.
        """
        node = int(np.searchsorted(self._middles, at))
        point = int(self._points[node])
        if point < 0 or abs(self._nodes[node] - at) > 1e-6 * self._nodes[-1]:
            raise ParameterError(f"loads: the robot has no node at s = {at:g} m: name it among the rod's stations")
        return node, point
