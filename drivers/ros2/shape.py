"""The rod as the model has it under the commanded tensions, to be drawn."""

from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.ros2.messages import Place
from tendond.model import ModelError
from tendond.model.numerics.rotation import quaternion
from tendond.model.rods.selection import model_rod
from tendond.schemas.base import Vector3
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import TendonCommand

Array = NDArray[np.float64]


class Shape:
    """A rod that follows the commands; it is a picture, the controller's estimate is another.

    Args:
        config: of the rig.

    Attributes:
        target: of the reference [m].
    """

    def __init__(self, config: RigConfig) -> None:
        self._rod = model_rod(config)
        self._state: Any = self._rod.solve_static([0.0] * self._rod.parameters.tendon_count)
        self.target: Vector3 = (0.0, 0.0, 0.0)

    def advance(self, command: TendonCommand) -> None:
        """Advance the rod by a cycle under a command's tensions."""
        if len(command.tension) != self._rod.parameters.tendon_count:
            return  # of another robot: the controller refuses it
        with suppress(ModelError):  # the rod is then drawn in its last shape
            self._state = self._rod.step(self._state, [max(0.0, tension) for tension in command.tension])

    def tip(self) -> Place:
        """Return position [m] and orientation w, x, y, z of the tip, in the base's frame."""
        end = self._rod.tip(self._state)
        x, y, z = end.position.tolist()
        return (x, y, z), quaternion(end.rotation)

    def lines(self) -> tuple[Array, list[Array]]:
        """Return points of the backbone [m], shape (n, 3), and of each tendon [m], shapes (k, 3)."""
        return self._rod.curve(self._state), self._rod.tendon_paths(self._state)
