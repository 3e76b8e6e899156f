"""A setup of the pure cycle with a real rod, and functions that run it."""

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.drivers.simulator.lockstep import without_probe
from tendond.model.numerics.rotation import quaternion
from tendond.schemas.base import Quaternion
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, TendonState, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction

CONFIG = without_probe(RigConfig())
SETUP = CycleSetup.from_config(CONFIG)
START = initial_state(SETUP)
REST = tuple(SETUP.rod.tip(START.rod).position.tolist())
UPRIGHT = quaternion(SETUP.rod.tip(START.rod).rotation)
"""The tip at rest: position [m] and orientation."""


def pose(
    seq: int, position: tuple[float, ...] = REST, orientation: Quaternion = UPRIGHT, *, valid: bool = True
) -> TipPose:
    x, y, z = position
    return TipPose(seq=seq, stamp_ns=0, position=(x, y, z), orientation=orientation, valid=valid)


def go(state: CycleState, *inputs: CycleInputs) -> tuple[CycleState, CycleRecord]:
    for one in inputs:
        state, _, record = step(SETUP, state, one)
    return state, record


def armed(cycles: int = 22) -> CycleState:
    """A state that is tracking, fed with poses where the model is."""
    state, record = go(START, CycleInputs(pose=pose(0)), CycleInputs(pose=pose(1), request=ControlAction.ARM))
    assert record.accepted
    for _ in range(cycles):
        state, record = go(state, CycleInputs(pose=follow(state)))
    assert record.mode is Mode.TRACKING
    return state


def follow(state: CycleState) -> TipPose:
    assert state.pose is not None
    tip = SETUP.rod.tip(state.rod)
    return pose(state.pose.seq + 1, tuple(tip.position.tolist()), quaternion(tip.rotation))


def sick(seq: int, fault: str = "") -> TendonState:
    """A driver's report of tendons that are taut."""
    return TendonState(seq=seq, stamp_ns=0, displacement=(0.0,) * 4, tension=(12.0,) * 4, fault=fault)
