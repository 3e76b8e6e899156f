"""The camera in a calibration: how far, and towards which tendon, the tip bends when a servo pulls."""

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

import zenoh

from tendond.bus.client import BusError, open_client
from tendond.bus.subscription import Subscription
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.keys import TIP_POSE, key
from tendond.schemas.messages import TipPose

CONNECT_SECONDS = 0.3
LISTEN_SECONDS = 0.5
QUEUE = 64
POSES = 5
"""Valid poses within `LISTEN_SECONDS` that a mean needs."""

Bend = tuple[float, float]
"""Angle by which the tip's axis leans, times the direction in which it does [rad]."""


def bend_of(orientation: Sequence[float]) -> Bend:
    """Compute the bend of a tip.

    Args:
        orientation: orientation of the tip, w, x, y, z, body to world.
    """
    w, x, y, z = orientation
    across_x, across_y, along = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)
    across = math.hypot(across_x, across_y)
    if across == 0.0:
        return 0.0, 0.0
    angle = math.atan2(across, along)
    return angle * across_x / across, angle * across_y / across


def shortened(position: Sequence[float], before: Bend, after: Bend) -> float:
    """Compute by how much a tendon's path along the rod has shortened [m].

    A tendon parallel to the axis at p is shorter by p . theta e where the rod bends by theta towards e in one plane,
    however the curvature is spread (constant in none): each length ds of the axis turns by d theta, and the tendon's is
    ds - (p . e) d theta.

    Args:
        position: position of the tendon in the cross-section [m], x and y.
        before: bend.
        after: bend.
    """
    return position[0] * (after[0] - before[0]) + position[1] * (after[1] - before[1])


class Camera:
    """Tip poses from the bus; use as a context.

    Args:
        config: configuration of the rig.
    """

    def __init__(self, config: RigConfig) -> None:
        self._config = config
        self._session: zenoh.Session | None = None

    def __enter__(self) -> "Camera":
        with suppress(BusError):
            self._session = open_client(self._config.bus.endpoint, CONNECT_SECONDS)
        return self

    def __exit__(self, *_: object) -> None:
        if self._session is not None:
            self._session.close()

    def bend(self, meanwhile: Callable[[], object] = lambda: time.sleep(0.005)) -> Bend | None:
        """Measure the mean bend of the tip; none where no camera measures it.

        Args:
            meanwhile: called repeatedly while waiting: a servo that holds needs commands.
        """
        if self._session is None:
            return None
        found: list[Bend] = []
        name = key(self._config.rig.name, TIP_POSE)
        poses = Subscription(self._session, name, TipPose, QUEUE)
        until = time.monotonic() + LISTEN_SECONDS
        while time.monotonic() < until:
            arrived = [bend_of(pose.orientation) for pose in poses if pose.valid]
            found += arrived
            if not arrived:
                meanwhile()
        poses.close()
        if len(found) < POSES:
            return None
        return sum(one[0] for one in found) / len(found), sum(one[1] for one in found) / len(found)
