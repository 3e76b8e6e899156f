"""Tips that a rod predicts for a sequence of commands, with play and dry friction, which remember the sequence.

A tendon is behind a play operator: its displacement u follows the command c only as |c - u| exceeds the half-width

    w = backlash + T (1 - exp(-friction theta)) / k,

the capstan's loss of tension over the bend theta up to the tendon's end, as a displacement of the tendon's spring
(M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis, 1989, chapter 2). T and theta are those of the pose
before: the operator is explicit in the sequence.

Dry friction within the backbone, of wires in guides and of a superelastic wire, is a spring that yields, beside the
elastic one (W. D. Iwan, "A distributed-element model for hysteresis", J. Appl. Mech. 33, 1966): a section's moment is
EI (u - c p), where p follows the section's mean curvature u only as |u - p| exceeds the yield curvature, and c is the
share of the stiffness that yields.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError
from tendond.model.numerics.compile import Bound
from tendond.model.strain import StrainRod
from tendond.model.strain.minima.minimise import minimise
from tendond.model.strain.stepping.scratch import scratch_for
from tendond.offline.validation.rods.build import Measured
from tendond.offline.validation.rods.memory import Memory

Array = NDArray[np.float64]

TOLERANCE = 1e-8
"""Tolerance of a rest [rad]: the tip is then 1e-9 of the length off, far below the step of a difference quotient."""

ROUNDS = 4
"""Largest number of rests of a pose, between which the backbone yields."""

_MINIMISE = Bound(minimise)


@dataclass(frozen=True)
class Prediction:
    """What a rod does along a sequence of commands.

    Attributes:
        tip: position of the marker [m], shape (N, 3). tension: of the tendons, EI = 1 N m^2, shape (N, m).
        drawn: the tendons' displacements behind the play [m], shape (N, m).
        failed: number of poses without an equilibrium; each has the best shape that was found.
    """

    tip: Array
    tension: Array
    drawn: Array
    failed: int


def predict(measured: Measured, command: Array) -> Prediction:
    """Return the rests along commands [m], shape (N, m), from the first one on.

    Raises:
        ConvergenceError: not finite.
    """
    rod = StrainRod(measured.robot)
    layout, work = rod.layout, scratch_for(rod.layout)
    loads = rod.loads(displacement=[0.0] * command.shape[1])
    q = np.zeros(rod.modes)
    aims = measured.spool * command - measured.zero
    drawn = aims.copy()
    lag = measured.backlash > 0.0 or measured.friction > 0.0
    memory = Memory(layout, measured.yielding, measured.yield_curvature) if measured.yielding > 0.0 else None
    tip, tension = np.empty((len(command), 3)), np.empty(command.shape)
    held, failed = aims[0].copy(), 0
    ends = [rod.node(tendon.end)[0] for tendon in measured.robot.tendons] if measured.friction > 0.0 else []
    along = layout.base.reshape(3, 3)[:, 2]
    width = np.full(command.shape[1], measured.backlash)
    for i, aim in enumerate(aims):
        if lag:
            held = np.minimum(np.maximum(held, aim - width), aim + width)
            drawn[i] = held
        loads.tension[:] = drawn[i]
        for _ in range(ROUNDS):
            if _MINIMISE.call(layout, loads, q, 0.0, TOLERANCE, work) < 0:
                q[:] = 0.0
                failed += int(_MINIMISE.call(layout, loads, q, 0.0, TOLERANCE, work) < 0)
            if memory is None or not memory.yield_to(q):
                break
        shape = work.after
        turn = shape.rotation[-1].reshape(3, 3)
        tip[i] = shape.position[-1] + turn @ measured.marker
        tension[i] = work.taut
        if ends:
            bend = np.arccos(np.clip(shape.rotation[ends][:, [2, 5, 8]] @ along, -1.0, 1.0))
            width = measured.backlash + tension[i] * -np.expm1(-measured.friction * bend) / layout.tendon_stiffness
    if not np.all(np.isfinite(tip)):
        raise ConvergenceError("statics: a tip is not finite", 0.0, 0.0, 0)
    return Prediction(tip, tension, drawn, failed)
