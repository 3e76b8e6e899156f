"""Camera and tendon drive about a plant: poses are delayed and noisy, commands are held.

Units, signs and frames are those of schemas/messages.py, of which no line is in it.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tests.plants.paper_robot import PaperRobot, Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RigSettings:
    """Camera and drive of the robot.

    Attributes:
        period: between poses [s].
        delay: delay of a pose, in periods.
        noise: standard deviation of a pose's position, each axis [m].
        displacement: winches follow the displacement command, else motors the tension command.
        winch_rate: largest speed of the tendons' ends [m/s]; 0: no limit.
        seed: seed of the noise.
    """

    period: float = 0.01
    delay: int = 0
    noise: float = 0.0
    displacement: bool = False
    winch_rate: float = 0.0
    seed: int = 0


class MujocoRig:
    """Robot at rest with a camera and a drive for its tendons.

    Args:
        robot: parameters of the plant. rig: parameters of camera and drive.
    """

    def __init__(self, robot: Robot, rig: RigSettings) -> None:
        self.plant = PaperRobot(robot)
        self._rig = rig
        self._random = np.random.default_rng(rig.seed)
        self._poses: deque[tuple[Array, Array]] = deque(maxlen=rig.delay + 1)
        self._ends: Array | None = None

    def pose(self) -> tuple[Array, Array]:
        """Return the position [m], shape (3,), and quaternion w, x, y, z, shape (4,), that the camera reports now.

        Call it once a period.
        """
        noise = self._random.normal(0.0, self._rig.noise, 3) if self._rig.noise else np.zeros(3)
        self._poses.append((self.plant.position + noise, self.plant.quaternion))
        return self._poses[0]

    def advance(self, tension: Array, displacement: Array, armed: bool) -> None:
        """Simulate one period under a command.

        Args:
            tension: [N], shape (n,). displacement: [m], shape (n,). armed: false switches the torque off.
        """
        if not armed:
            self.plant.release()
            self._ends = None
        elif not self._rig.displacement:
            self.plant.set_tension(tension)
        else:
            at = self.plant.displacement if self._ends is None else self._ends
            reach = self._rig.winch_rate * self._rig.period if self._rig.winch_rate else np.inf
            self._ends = at + np.clip(displacement - at, -reach, reach)
            self.plant.set_displacement(self._ends)
        self.plant.advance(self._rig.period)
