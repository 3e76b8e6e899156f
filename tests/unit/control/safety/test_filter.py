"""The filter in the cycle: with every law it stops the arm before what it would run into, and is recorded."""

from functools import cache

import numpy as np
import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.phases.faults import find_fault
from tendond.daemon.control.phases.prediction import Limited
from tendond.daemon.control.phases.protection import protect
from tendond.daemon.control.safety.configured import target_remark
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState, changed
from tendond.daemon.errors import SafetyError
from tendond.drivers.simulator.lockstep import Watched, watched_loop, without_probe
from tendond.schemas.config.rig import RigConfig, parse_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

CENTER, RADIUS, ARM = np.array([0.25, 0.0, 0.42]), 0.05, 0.02
RIG = """
[control]
law = "{law}"
solver = "general"
[reference]
across = 0.25
[simulator.rod.scale]
stiffness = 0.93
"""
BALL = f"""
[safety]
margin = 0.003
[[safety.obstacle]]
name = "lamp"
kind = "sphere"
center = {CENTER.tolist()}
radius = {RADIUS}
"""
CYCLES = 90


@cache
def ran(law: str, safety: str) -> tuple[list[Watched], list[CycleState], RigConfig]:
    config = parse_config(RIG.format(law=law) + safety, "test")
    states: list[CycleState] = []
    return list(watched_loop(config, CYCLES, {2: ControlAction.ARM}, 40, states.append)), states, config


def clearance(watched: list[Watched]) -> float:
    shapes = np.array([one.shape for one in watched])
    return float(np.linalg.norm(shapes - CENTER, axis=2).min()) - RADIUS


@pytest.mark.parametrize("law", ["backstepping", "sliding_mode", "sensitivity"])
def test_the_true_arm_stays_clear_and_without_the_filter_does_not(law: str) -> None:
    plain, guarded = clearance(ran(law, "")[0]), clearance(ran(law, BALL)[0])
    assert plain < 0.0
    assert guarded >= ARM
    last = ran(law, BALL)[0][-1].record
    assert last.mode is Mode.TRACKING
    assert guarded <= ARM + 0.03, "it stops near the obstacle, not where it started"


def test_interventions_are_recorded_and_rests_at_the_obstacle_are_no_fault() -> None:
    records = [one.record for one in ran("sensitivity", BALL)[0]]
    altered = [one.safety for one in records if one.safety is not None]
    assert len(altered) > CYCLES // 3
    assert {one.constraint for one in altered} == {"lamp"}
    assert all(one.kept for one in altered)
    assert all(one.altered > 0.0 for one in altered)
    assert all(one.safety is None for one in records if one.mode is Mode.IDLE)
    assert '"safety"' not in ran("sensitivity", "")[0][-1].record.model_dump_json()


def test_commands_stay_within_their_limits_and_finite() -> None:
    watched, _, config = ran("backstepping", BALL)
    tensions = np.array([one.record.command.tension for one in watched])
    limits = config.with_own_rates().limits
    assert np.isfinite(tensions).all()
    assert tensions.min() >= limits.tension_min
    assert np.abs(np.diff(tensions, axis=0)).max() <= limits.tension_rate * config.loop.period * (1.0 + 1e-12)


def test_a_cycle_is_computed_again_to_the_last_bit_from_a_snapshot() -> None:
    watched, states, config = ran("sensitivity", BALL)
    setup = CycleSetup.from_config(
        config.model_copy(update={"commissioning": config.commissioning.model_copy(update={"probe": False})})
    )
    for tick in (40, 60):
        state = decode_state(CycleState, encode_state(states[tick]), setup)
        _, _, record = step(setup, state, watched[tick].record.inputs)
        assert record == watched[tick].record


def test_a_resting_arm_in_an_obstacle_is_refused_in_one_line() -> None:
    inside = BALL.replace("[0.25, 0.0, 0.42]", "[0.0, 0.0, 0.42]")
    config = parse_config(RIG.format(law="backstepping") + inside, "test")
    with pytest.raises(SafetyError, match=r"resting arm is .* mm too near to 'lamp'") as refused:
        CycleSetup.from_config(config)
    assert "\n" not in str(refused.value)


def test_a_target_in_an_obstacle_is_remarked() -> None:
    barrier = CycleSetup.from_config(ran("sensitivity", BALL)[2]).barrier
    assert "lamp" in target_remark(barrier, (0.25, 0.0, 0.42))
    assert target_remark(barrier, (0.0, 0.0, 0.5)) == ""
    assert target_remark(None, (0.0, 0.0, 0.5)) == ""


def test_a_robot_that_is_pushed_towards_an_obstacle_pulls_against_it() -> None:
    push = "\n[[simulator.impacts]]\ntime = 0.3\nduration = 5.0\nforce = [2.0, 0.0, -1.0]\n"
    near = RIG.format(law="sensitivity").replace("0.25", '0.05\nunreachable = "track"')
    config = parse_config(near + "[limits]\ntension_max = 3.0\n" + BALL + push, "test")
    records = [one.record for one in watched_loop(config, 70, {2: ControlAction.ARM})]
    assert any(one.safety is not None and not one.safety.kept for one in records)
    assert records[-1].command.tension[2] > records[29].command.tension[2] + 1.0


def test_constraints_that_no_command_keeps_for_long_are_a_fault() -> None:
    _, states, config = ran("sensitivity", BALL)
    setup = CycleSetup.from_config(without_probe(config))
    most = setup.thresholds.unsafe_time
    for unsafe, said in ((most - 1, False), (most, True)):
        state = changed(states[50], bad_cycles=changed(states[50].bad_cycles, unsafe=unsafe))
        assert find_fault(setup, state).startswith("safety: no command keeps") is said


def test_a_filter_that_fails_holds_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    _, states, config = ran("sensitivity", BALL)
    setup, state = CycleSetup.from_config(without_probe(config)), states[50]

    def fails(*_: object) -> None:
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(setup.barrier, "filter", fails)
    found = protect(setup, state, Limited(state.tension_command + 0.5, ()))
    np.testing.assert_array_equal(found.limited.tension, state.tension_command)
    assert found.intervention is not None
    assert not found.intervention.kept
    assert found.state.bad_cycles.unsafe == state.bad_cycles.unsafe + 1
