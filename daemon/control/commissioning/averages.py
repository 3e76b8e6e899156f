"""Means of poses over short blocks: what a resting tip is judged by, and whether it rests.

`python -m tests.constants` has the outcome with half and twice of each constant.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.base import Quaternion, Vector3

Array = NDArray[np.float64]

REST_BLOCK_SECONDS = 0.25
"""A mean over a period of 4 Hz and more; an arm that swings slower shows it from one block to the next. With half
and twice of it the same rigs are refused (`python -m tests.constants REST_BLOCK_SECONDS`)."""

ENOUGH = 5
"""Poses of a block that is preferred to the one before it: those of a camera of 20 Hz. Fewer and more
make no difference at the default rates (`python -m tests.constants ENOUGH`)."""

STILL = 0.01
"""Largest difference of the means of two blocks of a resting tip, and of half its spread, of the rod's length:
half of the default motion of a probe. Half and twice of it make no difference (`python -m tests.constants STILL`)."""


@dataclass(frozen=True)
class Average:
    """Sum and extremes of poses.

    Attributes:
        count: number of poses.
        position: sum [m]. orientation: sum, w, x, y, z, of the signs of the first one.
        low, high: smallest and largest coordinates [m].
    """

    count: int
    position: Vector3
    orientation: Quaternion
    low: Vector3
    high: Vector3

    def add(self, position: Vector3, orientation: Quaternion) -> "Average":
        """Return the same with one more pose."""
        (x, y, z), (px, py, pz) = position, self.position
        (a, b, c), (d, e, f) = self.low, self.high
        w, i, j, k = orientation
        qw, qi, qj, qk = self.orientation
        sign = -1.0 if w * qw + i * qi + j * qj + k * qk < 0.0 else 1.0
        return Average(
            self.count + 1,
            (px + x, py + y, pz + z),
            (qw + sign * w, qi + sign * i, qj + sign * j, qk + sign * k),
            (min(a, x), min(b, y), min(c, z)),
            (max(d, x), max(e, y), max(f, z)),
        )

    @property
    def mean(self) -> Array:
        """Position [m], shape (3,)."""
        return np.array(self.position) / self.count

    @property
    def mean_orientation(self) -> Quaternion:
        """Unit quaternion w, x, y, z; of no rotation where opposite ones cancel."""
        q = np.array(self.orientation)
        size = float(np.linalg.norm(q))
        w, x, y, z = (q / size).tolist() if size > 0.0 else (1.0, 0.0, 0.0, 0.0)
        return w, x, y, z

    @property
    def spread(self) -> float:
        """Diagonal of the box that holds all positions [m]."""
        return float(np.linalg.norm(np.subtract(self.high, self.low)))


FAR = 1e9
"""Coordinate beyond every tip's, from which smallest and largest ones begin [m]."""

EMPTY = Average(0, (0.0,) * 3, (0.0,) * 4, (FAR,) * 3, (-FAR,) * 3)


@dataclass(frozen=True)
class RestWatch:
    """The tip while no tendon pulls.

    Attributes:
        cycles: length of the present block. now: its average. before: that of the whole one before it, if there is one.
    """

    cycles: int = 0
    now: Average = EMPTY
    before: Average | None = None

    def add(self, position: Vector3 | None, orientation: Quaternion | None, block: int) -> "RestWatch":
        """Return the watch a cycle later; with the cycle's new pose, if there was one. `block` is in cycles."""
        before, now, cycles = self.before, self.now, self.cycles + 1
        if cycles > block:
            before, now, cycles = (now if now.count else None), EMPTY, 1
        if position is not None and orientation is not None:
            now = now.add(position, orientation)
        return RestWatch(cycles, now, before)

    @property
    def best(self) -> Average | None:
        """The block to judge by; none before the first pose."""
        if self.now.count >= ENOUGH or self.before is None:
            return self.now if self.now.count else None
        return self.before

    def moved(self, length: float) -> float:
        """Return the distance that a tip that does not rest has moved [m]; zero while it rests.

        Args:
            length: length of the rod [m].
        """
        blocks = [one for one in (self.before, self.now) if one is not None and one.count]
        spread = max((one.spread for one in blocks), default=0.0)
        drift = float(np.linalg.norm(blocks[0].mean - blocks[1].mean)) if len(blocks) == 2 else 0.0
        motion = max(drift, 0.5 * spread)
        return motion if motion > STILL * length else 0.0


RESTLESS = RestWatch()
