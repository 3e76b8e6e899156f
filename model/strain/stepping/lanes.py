"""Lanes of a batch: robots by their structure. Those of one structure are stepped in the same arrays of a worker."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.numerics.parked import address_of
from tendond.model.strain.layout import Index, Layout, lay_out
from tendond.model.strain.robot import Robot
from tendond.model.strain.stepping.many import Kinds, Room, measures_of
from tendond.model.strain.stepping.scratch import Loads, mirrored, scratch_for

Array = NDArray[np.float64]


class Part(NamedTuple):
    """Lanes of one structure that a worker steps, shape (k,), and the arrays in which it does."""

    room: Room
    lanes: Index


class Lanes:
    """Robots of a batch, N of them, laid out; one that is repeated is laid out once.

    Args:
        robots: with the same numbers of modes and of tendons.

    Attributes:
        layouts: of each lane, N of them. kinds: for the kernel.

    Raises:
        ParameterError: other numbers of modes or tendons than robot 0 has.
    """

    def __init__(self, robots: Sequence[Robot]) -> None:
        self._robots = tuple(robots)  # kept alive: their ids are keys
        found: dict[int, Layout] = {}
        for robot in robots:
            if id(robot) not in found:
                found[id(robot)] = lay_out(robot)
        self.layouts = [found[id(robot)] for robot in robots]
        for index, layout in enumerate(self.layouts):
            if sizes_of(layout) != sizes_of(self.layouts[0]):
                modes, tendons = sizes_of(layout)
                raise ParameterError(
                    f"batch: robot {index} has {modes} strain modes and {tendons} tendons, robot 0 has "
                    "{} and {}: all need the same numbers".format(*sizes_of(self.layouts[0]))
                )
        measures = [measures_of(layout) for layout in found.values()]
        table = np.zeros((len(measures), max(map(len, measures))))
        for row, one in zip(table, measures, strict=True):
            row[: len(one)] = one
        numbers = {key: index for index, key in enumerate(found)}
        self.kinds = Kinds(
            np.array([address_of(layout) for layout in self.layouts], dtype=np.int64),
            np.array([numbers[id(robot)] for robot in robots], dtype=np.int64),
            table,
        )
        groups: dict[object, list[int]] = {}
        structures = {id(layout): _structure_of(layout) for layout in found.values()}
        for index, layout in enumerate(self.layouts):
            groups.setdefault(structures[id(layout)], []).append(index)
        self._groups = [np.array(lanes, dtype=np.int64) for lanes in groups.values()]

    def parts(self, workers: int) -> list[list[Part]]:
        """Return what each of some workers steps: an even share of the lanes of each structure."""
        found: list[list[Part]] = [[] for _ in range(workers)]
        for lanes in self._groups:
            for worker, share in enumerate(np.array_split(lanes, workers)):
                if len(share) > 0:
                    found[worker].append(Part(_room_for(self.layouts[share[0]]), share))
        return found

    def pulls(self) -> Array:
        """Return room for the tensions along the tendons with friction, shape (N, F, 1 + Q) of the largest lane."""
        sizes = [pulls_shape(layout) for layout in self.layouts]
        return np.zeros((len(sizes), max(size[0] for size in sizes), max(size[1] for size in sizes)))


def sizes_of(layout: Layout) -> tuple[int, int]:
    """Return the numbers of strain modes and of tendons."""
    return len(layout.component), len(layout.straight)


def pulls_shape(layout: Layout) -> tuple[int, int]:
    """Return the shape of `StrainState.pulls`, (F, 1 + Q)."""
    return int(np.count_nonzero(layout.friction > 0.0)), 1 + len(layout.weight)


def _structure_of(layout: Layout) -> object:
    """Return what robots have in common that are stepped in the same arrays; to be compared."""
    numbers = (
        layout.component, layout.order, layout.first, layout.last, layout.place, layout.tendon_at != 0.0,
        layout.weight != 0.0, layout.friction > 0.0,
    )  # fmt: skip
    return tuple(np.shape(one) for one in layout), tuple(one.tobytes() for one in numbers)


def _room_for(layout: Layout) -> Room:
    """Return a worker's arrays for robots of a structure."""
    points, tendons, nodes = len(layout.mass), len(layout.straight), len(layout.polar)
    loads = Loads(
        np.zeros((points, 3)), np.zeros(tendons), np.zeros(tendons, dtype=np.bool_), np.zeros((nodes, 3))
    )  # fmt: skip
    tip = [j for j in range(points) if layout.place[j] == nodes - 1 and not layout.arm[j].any()]
    work = scratch_for(layout)
    return Room(work, mirrored(work), loads, np.array(tip[:1], dtype=np.int64))
