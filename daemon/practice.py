"""A few cycles that count for nothing: every kernel is then loaded, or compiled if it has to be."""

from dataclasses import replace

from tendond.daemon.cycle import step
from tendond.daemon.state import CycleSetup, CycleState, initial_state
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs


def practise(setup: CycleSetup) -> CycleState:
    """The initial state, which the practice leaves as it is.

    Raises:
        ConvergenceError: as `initial_state`.
    """
    state = initial_state(setup)
    practice = replace(state, mode=Mode.TRACKING, pose_age=0)
    tip = setup.rod.tip(state.rod)
    for seq in range(3):  # with poses: without one the observer does nothing
        pose = TipPose(seq=seq, stamp_ns=0, position=tuple(tip.position.tolist()), orientation=(1.0, 0.0, 0.0, 0.0))
        practice, _, _ = step(setup, practice, CycleInputs(pose=pose))
    return state
