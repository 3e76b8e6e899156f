"""The probe: each tendon in turn is pulled a little, and the tip's motion compared with the model's.

The tip rests first (`rest`), with nothing pulled. Then one tendon after another, once the one before it is let go,
takes a small tension along half a cosine (`pull`), and the mean positions of the measured and the model's tip are taken
over short blocks. A tendon that moves the tip as it should is passed at once; where it does not, the tip is given time
to settle, for a weight on it may swing at 1 Hz. Then the last tendon is let go (`release`), and `verdict.judge` says
what is wrong. A tendon whose motion has the right direction and the wrong size is pulled half as much again, and the
growth is compared: it does not depend on where the tendon became taut. The model runs freely meanwhile: it keeps the
force that holds it to the measured rest, unpulled.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.averages import EMPTY, Average, RestWatch
from tendond.daemon.control.commissioning.probe_plan import MORE, Phase, ProbePlan
from tendond.daemon.control.commissioning.rests import RestFamily
from tendond.daemon.control.commissioning.rotations import rotation_matrix, turn_by
from tendond.daemon.control.commissioning.verdict import Motion
from tendond.schemas.base import Vector3

Array = NDArray[np.float64]

TAKE_UP = 4.0
"""Factor on the rate of the first release, `ProbePlan.rate`, for taking up a tendon's slack: 1.5 of `ProbePlan.slack`,
with the motion, take 0.15 s of the default ramp of 0.2 s. With half of it some probes take 1 s longer, with twice
nothing changes (`python -m tests.constants TAKE_UP`)."""


@dataclass(frozen=True)
class Probe:
    """State of a probe.

    Attributes:
        phase: part of the probe; since: cycles in it. tendon: the one that is pulled.
        measured, model: tips of the present block.
        base, model_base: rests of the two [m]; none in the phase `rest`.
        displacement: commanded and reported at the rest [m].
        late: measured tips of the second half of the time to settle.
        last: mean of the block before; steady: blocks in a row with about the same.
        first: measured and expected motion at the first tension, while the second one is tried [m].
        released: tension of the tendon before this one, against the plan's [-].
        motions: motions of the tendons so far.
        start: tip when the probe began [m]. held: displacement that the tendons reported then [m]; none
            without a report.
        tilt: rotation of the base by the rest, axis times angle [rad]; offset: its shift [m]; camera frame. A tendon
            that is pulled feels where the tip is in the base's frame: there the model rests.
        only: the operator has asked for the probe alone.
        verdict: the defect found; empty if there is none, or not yet.
    """

    phase: Phase = Phase.REST
    since: int = 0
    tendon: int = 0
    measured: Average = EMPTY
    model: Average = EMPTY
    base: Vector3 | None = None
    model_base: Vector3 | None = None
    displacement: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    late: Average = EMPTY
    last: Vector3 | None = None
    steady: int = 0
    first: tuple[Vector3, Vector3] | None = None
    released: float = 1.0
    motions: tuple[Motion, ...] = ()
    start: Vector3 | None = None
    held: tuple[float, ...] | None = None
    tilt: Vector3 = (0.0, 0.0, 0.0)
    offset: Vector3 = (0.0, 0.0, 0.0)
    only: bool = False
    verdict: str = ""

    def in_base(self, position: Vector3) -> Vector3:
        """Return a measured position in the base's frame [m]."""
        return vector(turn_by(np.array(self.tilt)).T @ np.subtract(position, self.offset))


def start_probe(
    rests: RestFamily | None, watch: RestWatch, held: tuple[float, ...] | None = None, *, only: bool
) -> Probe:
    """Return a probe that begins; the base's place follows from the rest, where rests are compared.

    Args:
        rests: that a right rig may have. watch: of the tip at rest.
        held: reported displacement [m]. only: the operator has asked for the probe alone.
    """
    best = watch.best
    if rests is None or best is None:
        return Probe(only=only, held=held)
    fit = rests.fit(best.mean, rotation_matrix(best.mean_orientation))
    return Probe(only=only, held=held, start=vector(best.mean), tilt=vector(fit.tilt), offset=vector(fit.offset))


def probe_tension(plan: ProbePlan, probe: Probe) -> Array:
    """Tensions that the probe asks for now [N], shape (n,)."""
    tension = np.zeros_like(plan.tensions)
    down = 1.0 - _half_cosine(probe.since / plan.down)
    if probe.phase is Phase.PULL:
        low, high = (0.0, 1.0) if probe.first is None else (1.0, MORE)
        level = low + (high - low) * _half_cosine((probe.since - plan.start) / plan.ramp)
        tension[probe.tendon] = level * plan.tensions[probe.tendon]
        if probe.tendon and probe.first is None:
            tension[probe.tendon - 1] = down * probe.released * plan.tensions[probe.tendon - 1]
    elif probe.phase is Phase.RELEASE:
        tension[-1] = down * probe.released * plan.tensions[-1]
    return tension


def _half_cosine(part: float) -> float:
    """Return a half cosine from 0 to 1 with the fraction of a ramp that is done."""
    return 0.5 - 0.5 * math.cos(math.pi * min(1.0, max(0.0, part)))


def vector(values: Array) -> Vector3:
    """Return the three components of an array as numbers."""
    x, y, z = values.tolist()
    return x, y, z
