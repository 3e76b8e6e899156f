"""Jumps of the measured tip: one that lasts is no blow, no late poses and no missed deadlines."""

from tendond.daemon.control.commissioning.jump import POSES_AFTER, JumpWatch, watch_jump
from tendond.daemon.control.commissioning.tracking import TrackingBounds
from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode, TipPose
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction

BOUNDS = TrackingBounds.from_config(RigConfig())


def test_a_blow_is_no_jump_and_a_jump_is_none_while_the_tip_moves() -> None:
    watch = JumpWatch()
    for distance in (0.0, 0.001, 0.03, 0.05, 0.04, 0.01):  # it goes on moving
        watch = watch_jump(BOUNDS, watch, 1, distance, distance, (0.0, 0.0, 0.5))
        assert not watch.persistent
    watch = JumpWatch()
    for distance in (0.0, 0.001, 0.03, *(0.0005,) * POSES_AFTER):
        watch = watch_jump(BOUNDS, watch, 1, distance, distance, (0.0, 0.0, 0.5))
    assert watch.persistent


def test_an_arm_that_springs_back_after_a_push_of_one_cycle_has_not_jumped() -> None:
    """The turning point is one small step; a push of 10 N on an arm with stiff tendons, as the simulator has it."""
    watch = JumpWatch()
    for distance in (0.0, 0.0003, 0.0176, 0.005, 0.0095, 0.0098, 0.0057, 0.003, 0.0018):
        watch = watch_jump(BOUNDS, watch, 1, distance, distance, (0.0, 0.0, 0.5))
        assert not watch.persistent


def test_poses_that_were_held_up_are_no_jump_when_they_come_at_once() -> None:
    """The first of seven after a gap, then the newest of the rest: six cycles' distance at once."""
    watch = JumpWatch()
    for interval, distance in ((1, 0.006), (1, 0.006), (7, 0.006), (1, 0.036), (1, 0.006), (1, 0.006)):
        watch = watch_jump(BOUNDS, watch, interval, distance, distance, (0.0, 0.0, 0.5))
        assert not watch.withheld
        assert not watch.persistent
    watch = JumpWatch()
    still = ((1, 0.001),) * POSES_AFTER
    for interval, distance in ((1, 0.001), (7, 0.006), (1, 0.3), *still):  # further than any arm gets in the time
        watch = watch_jump(BOUNDS, watch, interval, distance, distance, (0.0, 0.0, 0.5))
    assert watch.persistent


def test_a_pose_after_missed_deadlines_is_no_jump() -> None:
    """The arm went on while the controller stood still, and the model did not."""
    setup = CycleSetup.from_config(parse_config("[commissioning]\nrest = false\nprobe = false\n", "test"))
    state = initial_state(setup)
    for tick, missed in enumerate((0, 0, 6, 0)):
        x = 0.0 if tick < 2 else 0.12
        pose = TipPose(seq=tick, stamp_ns=0, position=(x, 0.0, 0.48), orientation=(1.0, 0.0, 0.0, 0.0))
        request = ControlAction.ARM if tick == 1 else None
        state, _, record = step(setup, state, CycleInputs(pose=pose, missed_ticks=missed, request=request))
        assert not state.jump_watch.withheld
    assert record.mode is not Mode.FAULT
