"""Protect: alter a limited command as little as possible, so that it keeps the constraints of [safety]."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.actuation import limit_tension
from tendond.daemon.control.phases.estimation import corrected_tip
from tendond.daemon.control.phases.prediction import Limited
from tendond.daemon.control.safety.barrier import Barrier, Filtered
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, changed
from tendond.model.errors import ModelError
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.rods.general import GeneralState
from tendond.schemas.messages import Mode
from tendond.schemas.record import Intervention

Array = NDArray[np.float64]

PROTECTED = (Mode.PRETENSION, Mode.TRACKING)
"""Modes with the filter: the probe's pulls are small, and a release must not be held up."""

UNALTERED = 1e-9
"""Change of a command that is rounding [N]."""

NO_MOTION = "model"
"""Name in messages of what stands in the way where the model has no step to look ahead with."""


class Protected(NamedTuple):
    """State with the count of cycles without an allowed command, the command, and the intervention, if there is one."""

    state: CycleState
    limited: Limited
    intervention: Intervention | None


def protect(setup: CycleSetup, state: CycleState, limited: Limited) -> Protected:
    """Return the allowed command nearest to the limited one; in modes without the filter, the same."""
    if setup.barrier is None or state.mode not in PROTECTED or not isinstance(state.rod, GeneralState):
        return Protected(_counted(state, 0), limited, None)
    found = _filtered(setup, setup.barrier, state, state.rod, limited.tension)
    if not np.isfinite(found.command).all():
        found = Filtered(state.tension_command, found.constraint, 0.0, False, False)
    changes = found.command - limited.tension
    altered = float(np.max(np.abs(changes)))
    state = _counted(state, 0 if found.kept else state.bad_cycles.unsafe + 1)
    if altered <= UNALTERED and found.kept:
        return Protected(state, limited, None)
    intervention = Intervention.trusted(
        constraint=found.constraint, distance=found.distance, altered=altered, kept=found.kept
    )
    tension, _ = limit_tension(setup.config.limits, setup.config.loop.period, found.command, state.tension_command)
    if state.tracking_watch.error_cycles:  # a tip that is kept from its reference is not lost
        counted = max(0, state.tracking_watch.error_cycles - state.pose_interval)
        state = changed(state, tracking_watch=changed(state.tracking_watch, error_cycles=counted))
    met = tuple(name for name in limited.met if name == "not finite")  # the filter bounds the command, not the others
    return Protected(state, Limited(tension, met), intervention)


def _counted(state: CycleState, unsafe: int) -> CycleState:
    if state.bad_cycles.unsafe == unsafe:
        return state
    return changed(state, bad_cycles=changed(state.bad_cycles, unsafe=unsafe))


def _filtered(setup: CycleSetup, barrier: Barrier, state: CycleState, rod: GeneralState, wanted: Array) -> Filtered:
    limits, last, observer = setup.config.limits, state.tension_command, state.observer
    step = limits.tension_rate * setup.config.loop.period
    low = np.minimum(np.maximum(np.minimum(limits.tension_min, last + step), last - step), wanted)
    high = np.maximum(np.minimum(limits.tension_max, last + step), wanted)
    force = observer.tip_force if isinstance(observer, EstimatorState) else observer.force
    acting = observer.acting if isinstance(observer, EstimatorState) else _as_commanded
    shift = corrected_tip(state) + observer.offset - rod.position
    if setup.observer.kind == "force" and not isinstance(observer, EstimatorState):
        shift = shift + observer.innovation  # the force has yet to move the model there
    try:
        return barrier.filter(rod, state.tension_estimate, force, shift, wanted, low, high, acting)
    except (ModelError, np.linalg.LinAlgError):
        return Filtered(last, NO_MOTION, 0.0, False, False)


def _as_commanded(tensions: Array) -> Array:
    return tensions
