"""A few cycles that count for nothing: every kernel is then loaded, or compiled if it has to be.

With every law that the configuration admits: an operator may choose another one, and its first cycle must not compile.
"""

from contextlib import suppress
from dataclasses import replace

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.daemon.errors import DaemonError
from tendond.model.errors import ModelError
from tendond.model.warm import warm_up_filter
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction

CYCLES = 3


def warm_up(setup: CycleSetup) -> CycleState:
    """The initial state, which the warm-up leaves as it is.

    Raises:
        ConvergenceError: as `initial_state`.
    """
    state = initial_state(setup)
    if setup.estimator is not None:
        warm_up_filter()  # what weighs a contact is not met in a few quiet cycles
    _track(setup, state)
    for name in LAWS:
        with suppress(DaemonError):  # a law that does not go with reference or tendons cannot be chosen either
            selection = state.selection.with_law(setup.config, setup.rod, name)
            with suppress(ModelError):
                _track(setup, replace(state, selection=selection))
    return state


def _track(setup: CycleSetup, state: CycleState) -> None:
    """A few cycles of tracking, with poses: without one the observer does nothing; then a stop, and a reset."""
    state = replace(state, mode=Mode.TRACKING, pose_age=0)
    tip = setup.rod.tip(state.rod)
    for seq in range(CYCLES):
        pose = TipPose(seq=seq, stamp_ns=0, position=tuple(tip.position.tolist()), orientation=(1.0, 0.0, 0.0, 0.0))
        state, _, _ = step(setup, state, CycleInputs(pose=pose))
    if setup.tunable:  # the first request to tune prepares its checks, which takes many cycles
        settings = {key.path: key.configured for key in setup.tunable.values() if key.rate is not None}
        state, _, _ = step(setup, state, CycleInputs(request=ControlAction.SET, settings=settings))
    state, _, _ = step(setup, state, CycleInputs(request=ControlAction.JOG, jog=0.0))
    state, _, _ = step(setup, state, CycleInputs(request=ControlAction.STOP))
    fault = replace(state, mode=Mode.FAULT, bad_cycles=replace(state.bad_cycles, solver_failures=1))
    step(setup, fault, CycleInputs(request=ControlAction.RESET))
