"""Tensions at both ends of the tendons, as the controller's model has them: in record, status and exported log."""

import pytest

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import initial_state
from tendond.daemon.runtime.status import status_of
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model import RodParameters
from tendond.model.rods.friction import end_tensions, without_friction
from tendond.model.rods.selection import model_rod
from tendond.offline.logs.units import unit_of
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.health import LoopHealth
from tendond.schemas.messages import Status
from tendond.schemas.record import CycleRecord
from tendond.schemas.requests import ControlAction

FRICTION, ARM, ROD = 0.2, 0.02, RodParameters()


def rig(friction: float) -> RigConfig:
    robot = {"tendon_stiffness": 2e4, "tendon_friction": friction, "gravity": [0.0, 0.0, 0.0]}
    return check_config({"rod": robot, "control": {"solver": "general"}}, "test")


@pytest.mark.parametrize("pull", [10.0, 40.0])
def test_a_pulled_tendon_has_the_capstans_tension_at_the_tip_and_more_where_it_is_let_out(pull: float) -> None:
    """T' = -mu T k, EI k = r T: T(L) = T / (1 + mu r T L / EI)."""
    rod = model_rod(rig(FRICTION))
    pulled = rod.solve_static([pull, 0.0, 0.0, 0.0])
    expected = pull / (1.0 + FRICTION * ARM * pull * ROD.length / ROD.bending_stiffness)
    assert end_tensions(rod, pulled).tolist() == pytest.approx([expected, 0.0, 0.0, 0.0], rel=5e-3)
    let_out = rod.solve_static([0.5 * expected, 0.0, 0.0, 0.0], start=pulled)
    assert end_tensions(rod, let_out)[0] > 0.5 * expected


def test_a_rod_without_friction_has_one_tension_and_rests_where_it_rests() -> None:
    rod = without_friction(model_rod(rig(FRICTION)))
    there = rod.solve_static([20.0, 0.0, 0.0, 0.0])
    back = rod.solve_static([20.0, 0.0, 0.0, 0.0], start=rod.solve_static([40.0, 0.0, 0.0, 0.0]))
    assert end_tensions(rod, there).tolist() == [20.0, 0.0, 0.0, 0.0]
    assert rod.tip(back).position == pytest.approx(rod.tip(there).position, abs=1e-6)
    shooting = model_rod(RigConfig())
    assert without_friction(shooting) is shooting
    assert end_tensions(shooting, shooting.solve_static([5.0, 0.0, 0.0, 0.0])).tolist() == [5.0, 0.0, 0.0, 0.0]


def test_the_record_has_both_ends_where_a_tendon_rubs_and_is_as_before_where_none_does() -> None:
    for friction in (0.0, FRICTION):
        config = rig(friction)
        *_, last = (one.record for one in watched_loop(config, 150, {5: ControlAction.ARM}))
        text = last.model_dump_json()
        assert ("tip_tension" in text) == (friction > 0.0)
        assert CycleRecord.model_validate_json(text) == last
        setup = CycleSetup.from_config(config)
        state = initial_state(setup)
        health = LoopHealth(cycles=1, missed_ticks=0, cycle_ms_median=0.5, cycle_ms_p99=0.9, log_dropped=0)
        status = status_of(setup, state, last, 1, health)
        assert status.tip_tension == last.tip_tension
        assert Status.model_validate_json(status.model_dump_json()) == status
        if friction > 0.0:
            assert len(last.tip_tension) == len(last.tension_estimate)
            assert 0.5 * last.tension_estimate[0] < last.tip_tension[0] < 0.95 * last.tension_estimate[0]
    assert unit_of("tip_tension") == "N"
