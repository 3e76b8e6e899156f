"""Simulated motion capture: frames, noise, latency, occlusion. The defaults of the section are ideal."""

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.faults import Faults
from tendond.drivers.simulator.rotations import turned
from tendond.model.numerics.rotation import quaternion
from tendond.model.rod.tip import Tip
from tendond.schemas.config.simulator import SimulatedMocap
from tendond.schemas.faults import Fault
from tendond.schemas.messages import TipPose

Array = NDArray[np.float64]

TOLERANCE = 1e-9
"""Rounding of simulated time [s]."""


class Mocap:
    """Simulated camera: poses of the tip with the section's errors and delays.

    Args:
        section: [simulator.mocap].
        seed: seed of the random numbers.
        faults: faults that requests have caused.
    """

    def __init__(self, section: SimulatedMocap, seed: int, faults: Faults) -> None:
        self._section = section
        self._faults = faults
        self._frozen: TipPose | None = None
        self._random = np.random.default_rng([seed, 1])
        self._next_frame = -math.inf
        self._hidden_until = -math.inf
        self._pending: deque[tuple[float, TipPose]] = deque()
        self.seq = -1

    def see(self, tip: Tip, time: float, stamp_ns: int) -> TipPose | None:
        """Expose a frame if one is due, and return the newest pose that arrives by `time` [s], if any.

        Args:
            tip: now.
            time: simulated [s].
            stamp_ns: capture time to write into a frame exposed now.
        """
        section = self._section
        if time >= self._next_frame - TOLERANCE:
            if self._next_frame == -math.inf and section.latency > 0.0:
                self._pending.append((-math.inf, self._frame(tip, stamp_ns)))  # as if it had rested there before
            self._next_frame = time + section.period
            if not self._lost():
                late = section.latency + section.jitter * self._random.random()
                self._occlude(time)
                hidden = time < self._hidden_until or self._faults.now(Fault.OCCLUSION) is not None
                self._pending.append((time + late, self._froze(self._frame(tip, stamp_ns, valid=not hidden))))
        arrived = None
        resting = len(self._pending) > 1 and self._pending[0][0] == -math.inf
        while self._pending and self._pending[0][0] <= time + TOLERANCE:
            if resting and self._pending[1][0] > time + TOLERANCE:
                arrived = self._pending[0][1]  # stays until the first frame has arrived
                break
            arrived = self._pending.popleft()[1]
        if arrived is None:
            return None
        self.seq += 1
        return arrived.model_copy(update={"seq": self.seq})

    def _lost(self) -> bool:
        """Draw whether this frame is lost."""
        asked = self._faults.now(Fault.DROPOUT)
        share = max(self._section.dropout, 0.0 if asked is None else asked.amount)
        return share > 0.0 and self._random.random() < share

    def _froze(self, pose: TipPose) -> TipPose:
        """Return `pose`, or the pose at which the camera froze."""
        if self._faults.now(Fault.FROZEN) is None:
            self._frozen = None
            return pose
        self._frozen = self._frozen or pose
        return pose.model_copy(update={"position": self._frozen.position, "orientation": self._frozen.orientation})

    def _occlude(self, time: float) -> None:
        section = self._section
        if section.occlusion > 0.0 and time >= self._hidden_until:
            span = max(section.period, 1e-3)
            if self._random.random() < 1.0 - math.exp(-section.occlusion * span):
                self._hidden_until = time + self._random.exponential(section.occlusion_time)

    def _frame(self, tip: Tip, stamp_ns: int, *, valid: bool = True) -> TipPose:
        section = self._section
        position = tip.position
        asked = self._faults.now(Fault.NOISE)
        noise = section.noise if asked is None else math.hypot(section.noise, asked.amount)
        if noise > 0.0:
            position = position + noise * self._random.standard_normal(3)
        if (teleport := self._faults.now(Fault.TELEPORT)) is not None:
            position = position + np.array(teleport.vector)
        w, x, y, z = quaternion(tip.rotation)
        if section.rotation_noise > 0.0:
            w, x, y, z = turned((w, x, y, z), 0.5 * section.rotation_noise * self._random.standard_normal(3))
        px, py, pz = position.tolist()
        return TipPose(seq=0, stamp_ns=stamp_ns, position=(px, py, pz), orientation=(w, x, y, z), valid=valid)
