"""The outcome of a trial, from its log: where the tip rests, and how far that is from its target."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tendond.daemon.errors import DaemonError
from tendond.offline.logs.arrays import load
from tendond.schemas.base import Vector3
from tendond.schemas.messages import Mode

LAST_SECONDS = 0.5
"""Time at the end of tracking over which the tip is averaged [s]."""

ARRIVED = 0.02
"""Largest distance from the target at which a trial has succeeded, of the robot's length. Chosen: the rig profile, with
friction, play and delays, ends within 0.3 %."""

MOVING = 0.005
"""Largest distance of the tip from its mean over the last time at which it rests, of the robot's length: half of
faults.swing's default."""


@dataclass(frozen=True)
class TrialOutcome:
    """The outcome of a trial.

    Attributes:
        tip: mean of the true tip over the last time [m]. target: of the reference [m].
        error: distance between them [m]. motion: largest distance of the tip from its mean [m].
        length: of the robot [m].
    """

    tip: Vector3
    target: Vector3
    error: float
    motion: float
    length: float

    @property
    def arrived(self) -> bool:
        """True if the tip rests at its target."""
        return self.error <= ARRIVED * self.length and self.rests

    @property
    def rests(self) -> bool:
        """True if the tip rests anywhere."""
        return self.motion <= MOVING * self.length

    def in_words(self) -> str:
        """Describe it: 'the tip rests at x 70.0, y 0.0, z 183.1 mm, 0.01 mm from its target'."""
        x, y, z = (round(1e3 * one, 1) + 0.0 for one in self.tip)
        moves = "rests" if self.rests else f"still moves by {1e3 * self.motion:.2g} mm"
        return f"the tip {moves} at x {x:.1f}, y {y:.1f}, z {z:.1f} mm, {1e3 * self.error:.2g} mm from its target"


def outcome_of(path: Path) -> TrialOutcome:
    """Measure the last time of tracking in the log of a trial.

    Raises:
        DaemonError: there is no tracking, or no truth of a simulator. LogError: the log cannot be read.
    """
    run = load(path)
    tracking = np.flatnonzero(run["mode"] == Mode.TRACKING.value)
    if not tracking.size or "truth.position" not in run.names:
        raise DaemonError("the arm did not track")
    last = tracking[-max(1, round(LAST_SECONDS / run.config.loop.period)) :]
    tips = np.asarray(run["truth.position"][last], dtype=np.float64)
    tips = tips[~np.isnan(tips[:, 0])]
    if not tips.size:
        raise DaemonError("the simulator said nothing while the arm tracked")
    mean, target = tips.mean(axis=0), np.asarray(run["reference.position"][last[-1]], dtype=np.float64)
    x, y, z = mean.tolist()
    a, b, c = target.tolist()
    return TrialOutcome(
        (x, y, z),
        (a, b, c),
        float(np.linalg.norm(mean - target)),
        float(np.linalg.norm(tips - mean, axis=1).max()),
        run.config.rod.backbone_length,
    )
