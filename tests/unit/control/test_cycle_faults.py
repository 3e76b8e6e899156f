"""Faults in a cycle and their consequences: each row of the fault table, in pure functions."""

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.presets import PAPER
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, TendonState
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import CONFIG, REST, SETUP, armed, follow, go, pose


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


def test_a_servo_fault_releases_and_names_it() -> None:
    state = armed()
    sick = TendonState(seq=1, stamp_ns=0, displacement=(0.0,) * 4, tension=(0.0,) * 4, fault="servo 2: overload")
    _, record = go(state, CycleInputs(pose=follow(state), tendon_state=sick))
    assert record.mode is Mode.FAULT
    assert "servo 2: overload" in record.reason


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


def sick(seq: int, fault: str = "") -> TendonState:
    """A driver's report of tendons that are taut."""
    return TendonState(seq=seq, stamp_ns=0, displacement=(0.0,) * 4, tension=(12.0,) * 4, fault=fault)


def test_a_servo_error_releases_all_tendons_together() -> None:
    """Two tendons pull; the servo of one of them reports an error bit: both are let go in the same cycle."""
    setup = CycleSetup.from_config(
        parse_config(
            "[control]\nantagonist = 2\n[pretension]\nantagonist = 1.0\n[limits]\nrelease_rate = 10\n"
            "[commissioning]\nprobe = false\n",
            "test",
        )
    )
    state = initial_state(setup)
    inputs = [CycleInputs(pose=pose(k), request=ControlAction.ARM if k == 1 else None) for k in range(20)]
    for one in inputs:
        state, before, _ = step(setup, state, one)
    assert before.tension[0] > 0.5
    assert before.tension[2] > 0.5
    state, after, record = step(
        setup, state, CycleInputs(pose=pose(20), tendon_state=sick(1, "servo 3: overload error (bit 5)"))
    )
    assert record.reason == "tendons: servo 3: overload error (bit 5)"
    assert np.allclose(np.subtract(before.tension, after.tension), (0.1, 0.0, 0.1, 0.0))


def test_a_silent_tendon_driver_is_a_fault_once_it_has_spoken() -> None:
    state = armed()
    state, record = go(state, CycleInputs(pose=follow(state), tendon_state=sick(1)))
    for _ in range(SETUP.thresholds.tendon_timeout):
        state, record = go(state, CycleInputs(pose=follow(state)))
        assert record.mode is Mode.TRACKING
    state, record = go(state, CycleInputs(pose=follow(state)))
    assert (record.mode, record.reason) == (Mode.FAULT, "tendons stale: no state for 0.51 s")
    state, _ = go(state, *[CycleInputs(pose=pose(9000 + k)) for k in range(150)])
    state, record = go(state, CycleInputs(pose=pose(9200), request=ControlAction.RESET))
    assert record.accepted
    _, record = go(state, CycleInputs(pose=pose(9201), request=ControlAction.ARM))
    assert not record.accepted
    assert "said nothing" in record.reply


def test_a_tendon_state_out_of_order_is_dropped_and_counted() -> None:
    state, _ = go(armed(), CycleInputs(tendon_state=sick(7)))
    state, record = go(state, CycleInputs(tendon_state=sick(7, "an old fault")))
    assert record.rejected == ("tendons out of order",)
    assert record.mode is Mode.TRACKING


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


def test_a_rod_wound_up_further_than_the_solver_follows_is_a_fault_and_let_go() -> None:
    """A real failure of the solver: 480 N on the paper's rod while the measured tip stays where it was."""
    setup = CycleSetup.from_config(
        parse_config(
            "[limits]\ntension_max = 500.0\ndisplacement_max = 1.0\ndisplacement_min = -1.0\n"
            "displacement_rate = 1000.0\n[pretension]\ntension = 480.0\nduration = 1.0\n"
            "[reference]\nunreachable = 'track'\n[faults]\nmismatch = 100.0\nfrozen_distance = 1000.0\n"
            "[commissioning]\nprobe = false\n",
            "test",
        )
    )
    state, errors = initial_state(setup), 0
    x, y, z = REST
    for k in range(1000):
        inputs = CycleInputs(pose=pose(k, (x, y + 1e-5 * (k % 2), z)), request=ControlAction.ARM if k == 2 else None)
        state, command, record = step(setup, state, inputs)
        errors += bool(record.model.error)
        assert np.isfinite(command.tension).all()
        if record.mode is Mode.FAULT and not any(command.tension):
            break
    assert errors > setup.thresholds.solver_timeout
    assert record.reason == "model: no solution for 0.06 s"
    assert not command.armed


def test_what_cannot_be_wound_is_not_pulled() -> None:
    """A displacement limit holds the tension, so that the arm stops there, and is a fault when it lasts."""
    config = parse_config("[limits]\ndisplacement_max = 0.03\n", "test")
    records = list(closed_loop(config, 300, {5: ControlAction.ARM}))
    assert max(record.command.displacement[0] for record in records) <= 0.03
    assert max(record.inputs.tendon_state.displacement[0] for record in records if record.inputs.tendon_state) < 0.045
    fault = next(record for record in records if record.mode is Mode.FAULT)
    assert "limits" in fault.reason
