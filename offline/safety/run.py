"""One run of the campaign: the true plant against the constraints, with the filter and without it."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tendond import TendondError
from tendond.daemon.control.safety.geometry import surfaces_of
from tendond.daemon.errors import SafetyError
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.offline.safety.cases import Case, drawn
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

CYCLES, POINTS = 150, 41
"""Cycles of a run, and points of the true backbone at which it is judged."""

ATTEMPTS = 20
"""Draws until an obstacle is clear of the resting arm."""

UNDER_CONTROL = (Mode.PRETENSION, Mode.TRACKING)


@dataclass(frozen=True)
class Outcome:
    """Outcome of a run.

    Attributes:
        seed, robot, law, kind: of the case.
        clearance: smallest distance of the true plant from the constraint, without margins, while the tendons were
            under control [-], of the length; of strain: of strain_max.
        released: the same over all cycles, with those of a release.
        without: clearance of the same run without the filter; none where that was not run.
        altered: cycles in which the filter altered the command. unkept: in which no command kept the constraints.
        ended: reason of a fault; empty without one.
    """

    seed: int
    robot: str
    law: str
    kind: str
    clearance: float
    released: float
    without: float | None
    altered: int
    unkept: int
    ended: str


def run(seed: int, *, compare: bool, cycles: int = CYCLES) -> Outcome:
    """Run once, so many cycles; `compare`: without the filter too.

    Raises:
        TendondError: no case can be drawn, or the plant has no solution.
    """
    for attempt in range(ATTEMPTS):
        case = drawn(seed, attempt)
        try:
            guarded = _Watch(case, case.config, cycles)
        except SafetyError:
            continue
        plain = _Watch(case, case.config.model_copy(update={"safety": None}), cycles) if compare else None
        return Outcome(
            seed, case.robot, case.law, case.kind, guarded.clearance, guarded.released,
            None if plain is None else plain.clearance, guarded.altered, guarded.unkept, guarded.ended,
        )  # fmt: skip
    raise TendondError(f"seed {seed}: no obstacle is clear of the resting arm in {ATTEMPTS} draws")


class _Watch:
    """A run, cycle by cycle; attributes as those of `Outcome`."""

    def __init__(self, case: Case, config: RigConfig, cycles: int) -> None:
        self.clearance = self.released = np.inf
        self.altered, self.unkept, self.ended = 0, 0, ""
        for watched in watched_loop(config, cycles, {2: ControlAction.ARM}, points=POINTS):
            distance, record = clearance_of(case, watched.shape), watched.record
            self.released = min(self.released, distance)
            if record.mode in UNDER_CONTROL:
                self.clearance = min(self.clearance, distance)
            if record.safety is not None:
                self.altered += 1
                self.unkept += not record.safety.kept
            if record.mode is Mode.FAULT and not self.ended:
                self.ended = record.reason
        if np.isinf(self.clearance):
            self.ended = self.ended or "it did not arm"


def clearance_of(case: Case, shape: Array) -> float:
    """Return the smallest distance of points of the true backbone from the constraints, shape (points, 3)."""
    section, rod = case.config.safety, case.config.rod
    assert section is not None
    length = rod.backbone_length
    if section.strain_max is not None:
        return 1.0 - _strain(shape, rod.outer_radius or rod.radius) / section.strain_max
    arm = max(float(np.hypot(x, y)) for x, y in rod.tendon_positions)
    first = int(np.ceil(min(section.stations) * (len(shape) - 1)))
    body = shape[first:]
    return float(np.min(surfaces_of(section, len(body), arm).measure(body).values)) / length


def _strain(shape: Array, fibre: float) -> float:
    """Return the largest bending strain of the outermost fibre, by angles between successive chords."""
    chords = np.diff(shape, axis=0)
    sizes = np.linalg.norm(chords, axis=1)
    angles = [
        2.0 * np.arcsin(min(1.0, 0.5 * float(np.linalg.norm(b / nb - a / na)))) / (0.5 * (na + nb))
        for (a, na), (b, nb) in pairwise(zip(chords, sizes, strict=True))
    ]
    return fibre * float(np.max(angles))
