"""Faults of servos and tendon reports: their name, and what is pulled meanwhile."""

import numpy as np

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.drivers.simulator.lockstep import closed_loop
from tendond.schemas.config.rig import parse_config
from tendond.schemas.messages import Mode, TendonState
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import REST, SETUP, armed, follow, go, pose, sick


def test_a_servo_fault_releases_and_names_it() -> None:
    state = armed()
    overloaded = TendonState(seq=1, stamp_ns=0, displacement=(0.0,) * 4, tension=(0.0,) * 4, fault="servo 2: overload")
    _, record = go(state, CycleInputs(pose=follow(state), tendon_state=overloaded))
    assert record.mode is Mode.FAULT
    assert "servo 2: overload" in record.reason


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


def test_a_rod_pulled_further_than_the_solver_follows_is_a_fault_and_released() -> None:
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


def test_a_tension_beyond_the_displacement_limit_is_not_applied() -> None:
    """A displacement limit holds the tension, so that the arm stops there, and is a fault when it lasts."""
    config = parse_config("[limits]\ndisplacement_max = 0.03\n", "test")
    records = list(closed_loop(config, 300, {5: ControlAction.ARM}))
    assert max(record.command.displacement[0] for record in records) <= 0.03
    assert max(record.inputs.tendon_state.displacement[0] for record in records if record.inputs.tendon_state) < 0.045
    fault = next(record for record in records if record.mode is Mode.FAULT)
    assert "limits" in fault.reason
