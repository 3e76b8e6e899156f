"""A few cycles that count for nothing: every kernel is then loaded, or compiled if it has to be."""

from dataclasses import replace

from tendond.daemon.cycle import step
from tendond.daemon.state import CycleSetup, CycleState, initial_state
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs


def practise(setup: CycleSetup) -> CycleState:
    """The initial state, which the practice leaves as it is.

    Raises:
        ConvergenceError: as `initial_state`.
    """
    state = initial_state(setup)
    practice = replace(state, mode=Mode.TRACKING, pose_age=0)
    for _ in range(3):
        practice, _, _ = step(setup, practice, CycleInputs())
    return state
