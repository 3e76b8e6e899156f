"""Faults in a cycle and their consequences: each row of the fault table, in pure functions."""

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import CONFIG, SETUP, armed, follow, go, pose, sick


def test_the_observer_bridges_a_gap_and_then_it_is_a_fault() -> None:
    state, record = go(armed(), *[CycleInputs()] * SETUP.thresholds.pose_timeout)
    assert record.mode is Mode.TRACKING
    state, record = go(state, CycleInputs())
    assert record.mode is Mode.FAULT
    assert "pose stale" in record.reason
    state, record = go(state, *[CycleInputs()] * 120)
    assert (record.mode, record.tension_estimate, record.command.armed) == (Mode.FAULT, (0.0,) * 4, False)


def test_a_fault_stays_until_reset() -> None:
    state, record = go(armed(), *[CycleInputs()] * 140)
    assert record.mode is Mode.FAULT
    state, record = go(state, CycleInputs(pose=pose(1000), request=ControlAction.ARM))
    assert (record.accepted, record.mode) == (False, Mode.FAULT)
    state, record = go(state, CycleInputs(pose=pose(1001), request=ControlAction.RESET))
    assert (record.accepted, record.mode) == (True, Mode.IDLE)
    _, record = go(state, CycleInputs(pose=pose(1002), request=ControlAction.ARM))
    assert (record.accepted, record.mode) == (True, Mode.PRETENSION)


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda s: pose(s.pose.seq, s.pose.position), "out of order"),
        (lambda s: pose(s.pose.seq - 2, s.pose.position), "out of order"),
        (lambda s: pose(s.pose.seq + 1, s.pose.position, valid=False), "occluded"),
        (lambda s: pose(s.pose.seq + 1, (0.0, 0.0, -0.74)), "teleport"),
        (lambda s: pose(s.pose.seq + 1, (1e308, 0.0, 0.0)), "out of reach"),
    ],
)
def test_a_bad_pose_is_dropped_with_its_reason_and_counted(make: object, reason: str) -> None:
    state = armed()
    assert callable(make)
    after, record = go(state, CycleInputs(pose=make(state)))
    assert record.rejected == (reason,)
    assert record.mode is Mode.TRACKING
    assert record.measured == state.pose.position if state.pose else False
    assert after.rejected[reason] == state.rejected.get(reason, 0) + 1


def test_unreadable_payloads_are_counted_by_reason() -> None:
    state, record = go(armed(), CycleInputs(unreadable={"malformed": 2, "not finite": 1}))
    assert state.rejected == {"malformed": 2, "not finite": 1}
    assert record.mode is Mode.TRACKING


def test_teleports_in_a_row_are_a_fault() -> None:
    state = armed()
    for k in range(SETUP.thresholds.teleport_time):
        assert state.mode is Mode.TRACKING
        state, record = go(state, CycleInputs(pose=pose(1000 + k, (0.0, 0.0, -0.74))))
    assert record.mode is Mode.FAULT
    assert "teleport" in record.reason


@pytest.mark.parametrize("jump", [0.25, 0.3, 0.5])
def test_a_jump_that_lasts_is_never_believed(jump: float) -> None:
    """However many of its poses have been refused: the time that has passed makes it no likelier."""
    state = armed()
    assert state.pose is not None
    x, y, z = state.pose.position
    for k in range(SETUP.thresholds.teleport_time):
        assert state.mode is Mode.TRACKING
        state, record = go(state, CycleInputs(pose=pose(1000 + k, (x, y + jump, z))))
        assert record.rejected == ("teleport",)
    assert record.mode is Mode.FAULT
    assert record.reason == "teleport: poses beyond what the tip can do for 0.05 s"


def test_after_a_short_jump_or_a_gap_the_tip_may_be_where_its_speed_allows() -> None:
    state = armed()
    assert state.pose is not None
    x, y, z = state.pose.position
    for k in range(SETUP.thresholds.teleport_time - 1):
        state, record = go(state, CycleInputs(pose=pose(1000 + k, (x, y + 0.3, z))))
        assert record.rejected == ("teleport",)
    _, record = go(state, CycleInputs(pose=pose(1010, (x, y + 0.1, z))))
    assert (record.rejected, record.mode) == ((), Mode.TRACKING)
    state, _ = go(armed(), *[CycleInputs()] * 3)
    _, record = go(state, CycleInputs(pose=pose(1010, (x, y + 0.3, z))))
    assert (record.rejected, record.mode) == ((), Mode.TRACKING)


def test_the_fastest_motion_of_the_papers_robot_is_no_teleport() -> None:
    config = parse_config(PAPER, "test")
    records = list(closed_loop(config, 160, {5: ControlAction.ARM}))
    tips = np.array([record.measured for record in records if record.measured is not None])
    steps = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    assert not any(record.rejected for record in records)
    limit = config.faults.tip_speed_max * config.loop.period
    assert 0.3 * limit < steps.max() < 0.7 * limit


def test_overruns_in_a_row_are_a_fault() -> None:
    state = armed()
    _, record = go(state, CycleInputs(pose=follow(state), missed_ticks=1))
    assert record.mode is Mode.TRACKING
    _, record = go(state, CycleInputs(pose=follow(state), missed_ticks=SETUP.thresholds.overrun_time))
    assert record.mode is Mode.FAULT
    assert "overrun" in record.reason


def test_a_model_without_solution_holds_and_then_faults(monkeypatch: pytest.MonkeyPatch) -> None:
    from tendond.model.errors import ConvergenceError

    def fail(*_: object, **__: object) -> None:
        raise ConvergenceError("a time step did not converge", 0.0, 1.0, 60)

    state = armed()
    monkeypatch.setattr(SETUP.rod, "step", fail)
    for _ in range(SETUP.thresholds.solver_timeout):
        state, record = go(state, CycleInputs(pose=follow(state)))
        assert record.mode is Mode.TRACKING
        assert "did not converge" in record.model.error
    state, record = go(state, *[CycleInputs(pose=follow(state))] * 2)
    assert record.mode is Mode.FAULT
    state, record = go(state, *[CycleInputs()] * 120)
    assert (record.tension_estimate, record.command.armed) == ((0.0,) * 4, False)
    assert max(record.command.displacement) == 0.0  # let out, not only without tension
    monkeypatch.undo()
    state, record = go(state, CycleInputs(pose=pose(2000), request=ControlAction.RESET))
    assert (record.accepted, record.model.error) == (True, "")
    _, record = go(state, CycleInputs(pose=pose(2001), request=ControlAction.ARM))
    assert record.accepted


def test_a_pose_that_stands_still_while_the_model_moves_is_a_fault() -> None:
    frozen = armed().pose
    state = armed()
    assert frozen is not None
    for k in range(SETUP.thresholds.frozen_time):
        assert state.mode is Mode.TRACKING
        state, record = go(state, CycleInputs(pose=pose(frozen.seq + 1 + k, frozen.position)))
    state, record = go(state, CycleInputs(pose=pose(frozen.seq + 100, frozen.position)))
    assert record.mode is Mode.FAULT
    assert "pose frozen: equal ones for 0.2 s" in record.reason


def test_a_model_at_rest_may_have_equal_poses_for_ever() -> None:
    records = list(closed_loop(CONFIG, 200, {5: ControlAction.ARM}))
    assert records[-1].mode is Mode.TRACKING
    # From here the pose never changes by a bit, as of a noise-free simulator.
    setup = CycleSetup.from_config(CONFIG)
    state = initial_state(setup)
    last = None
    for record in records:
        state, _, last = step(setup, state, record.inputs)
    assert last is not None
    still = last.inputs.pose
    assert still is not None
    for k in range(300):
        driver = sick(1000 + k)
        state, _, last = step(
            setup,
            state,
            CycleInputs(pose=pose(still.seq + 1 + k, still.position, still.orientation), tendon_state=driver),
        )
        assert last.mode is Mode.TRACKING, last.reason


def test_a_tip_that_is_far_from_the_models_for_long_is_a_fault_of_its_own() -> None:
    state = armed()
    length, reasons = CONFIG.rod.length, set[str]()
    away = tuple((np.array(SETUP.rod.tip(state.rod).position) * (1.0, 1.0, -1.0)).tolist())
    k = 0
    while state.mode is Mode.TRACKING and k < 400:  # a pose every second cycle jitters: neither frozen nor teleported
        k += 1
        near = state.pose.position if state.pose else away
        to = np.add(near, np.clip(np.subtract(away, near), -0.1, 0.1)) + 1e-5 * (k % 2)
        state, record = go(state, CycleInputs(pose=pose(5000 + k, tuple(to.tolist()))))
        reasons.add(record.reason)
    assert np.linalg.norm(state.observer.innovation) > CONFIG.faults.mismatch * length
    assert state.reason.startswith("mismatch: model and measured tip")
