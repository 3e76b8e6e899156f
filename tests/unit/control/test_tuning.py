"""Live tuning in the pure cycle: values move at a bounded rate, are checked like a configuration, and are replayed."""

import itertools

import pytest

from tendond.daemon.control.cycle import step
from tendond.daemon.control.laws.backstepping import LAW
from tendond.daemon.control.snapshot import decode_state, encode_state
from tendond.daemon.control.state import CycleState
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction
from tests.unit.control.cycles import SETUP, START, armed, follow, go, pose

ALPHA1 = "control.laws.backstepping.alpha1"
MAX = "limits.tension_max"
PERIOD = SETUP.config.loop.period


def asked(state: CycleState, key: str, value: float) -> tuple[CycleState, CycleRecord]:
    return go(state, CycleInputs(pose=follow(state), request=ControlAction.SET, settings={key: value}))


def test_a_gain_moves_to_its_new_value_by_its_marked_rate_and_no_faster_and_the_law_uses_it() -> None:
    state, record = asked(armed(), ALPHA1, 900.0)
    assert record.accepted
    assert record.reply == f"{ALPHA1} = 900, from 1500 within 1.3 s"
    rate, values = SETUP.tunable[ALPHA1].rate or 0.0, [1500.0]
    while values[-1] != 900.0:
        before = state
        state, record = go(state, CycleInputs(pose=follow(state)))
        values.append(record.tuned[ALPHA1])
        situation_error, wanted = record.terms["z1"], record.terms["z2"]
        assert record.estimate is not None
        # z2 = X2 - Xd' - alpha1 z1: the paper's, with the gain in use
        velocity = record.estimate.velocity[0] - record.reference.velocity[0]
        assert isinstance(situation_error, tuple)
        assert isinstance(wanted, tuple)
        assert wanted[0] == pytest.approx(velocity - values[-1] * situation_error[0], abs=1e-12)
        assert before.mode is Mode.TRACKING
        assert len(values) < 1000
    state, record = asked(state, ALPHA1, 1500.0)
    while record.tuned:
        state, record = go(state, CycleInputs(pose=follow(state)))
    assert not state.tuning  # back at the configuration's value it is no longer tuned
    steps = [late / early for early, late in itertools.pairwise(values)]
    assert all(1.0 / (1.0 + rate * PERIOD) - 1e-12 <= one < 1.0 for one in steps)
    assert len(values) > 100  # 1.3 s
    assert LAW.parameters().alpha1 == 1500.0


def test_a_lowered_limit_takes_the_tension_down_slowly_and_no_command_exceeds_it() -> None:
    state = armed(60)
    before = max(state.tension_command)
    state, record = asked(state, MAX, 0.8 * before)
    assert record.accepted
    for _ in range(700):
        last = max(state.tension_command)
        state, record = go(state, CycleInputs(pose=follow(state)))
        assert max(record.command.tension) <= record.tuned[MAX]
        if record.mode is not Mode.TRACKING:
            break
        assert last - max(record.command.tension) <= max(0.01 * last, SETUP.config.limits.tension_rate * PERIOD)
    assert record.tuned[MAX] < before
    assert record.mode is not Mode.TRACKING
    assert "limits" in state.reason  # as at any limit: the target needs more


@pytest.mark.parametrize(
    ("key", "value", "reason"),
    [
        (ALPHA1, -1.0, "must be a number > 0"),
        (ALPHA1, 1e6, "must be a number > 0 and <= 100000"),
        (MAX, 61.0, "must be 60 [N], the configuration's, or less; for more change the configuration"),
        (MAX, 0.5, "pretension.tension_min = 1 N must be below limits.tension_max = 0.5 N"),
        ("limits.slack", 0.001, "changes only while idle: tracking; stop first"),
        ("limits.slag", 0.001, "is not tunable: did you mean 'limits.slack'?"),
        ("rod.length", 0.4, "is not tunable: 'tendond rig get' lists those that are; change other keys in the config"),
    ],
)
def test_what_the_configuration_could_not_have_or_not_now_is_refused_in_a_line(
    key: str, value: float, reason: str
) -> None:
    state, record = asked(armed(), key, value)
    assert not record.accepted
    assert record.reply.startswith("not set: ")
    assert reason in record.reply
    assert "\n" not in record.reply
    assert not state.tuning
    assert record.mode is Mode.TRACKING


def test_while_idle_a_value_is_taken_at_once_and_the_configurations_own_leaves_nothing_tuned() -> None:
    state, _ = go(START, CycleInputs(pose=pose(0)))
    for key, value in (("limits.slack", 0.002), (ALPHA1, 900.0)):
        changed, record = asked(state, key, value)
        assert (record.accepted, record.reply) == (True, f"{key} = {value:g}")
        assert record.tuned == {key: value}
        back, record = asked(changed, key, SETUP.tunable[key].configured)
        assert record.accepted
        assert not back.tuning
        assert "tuned" not in record.model_dump_json()


def test_a_law_that_is_made_faster_than_the_observers_margin_is_remarked_upon_and_a_slower_one_is_not() -> None:
    state = armed()
    assert "remark: faster than what the observer's gains keep" in asked(state, ALPHA1.replace("1", "2"), 40.0)[1].reply
    assert "remark" not in asked(state, ALPHA1.replace("1", "2"), 10.0)[1].reply


def test_a_run_goes_on_to_the_last_bit_from_a_state_as_text_while_values_move() -> None:
    state = armed()
    state, _ = go(
        state, CycleInputs(pose=follow(state), request=ControlAction.SET, settings={ALPHA1: 900.0, MAX: 55.0})
    )
    state, _ = go(state, CycleInputs(pose=follow(state)))
    again = decode_state(CycleState, encode_state(state), SETUP)
    for _ in range(30):
        inputs = CycleInputs(pose=follow(state))
        state, _, record = step(SETUP, state, inputs)
        again, _, replayed = step(SETUP, again, CycleInputs.model_validate_json(inputs.model_dump_json()))
        assert replayed.model_dump_json() == record.model_dump_json()
    assert record.tuned[MAX] not in (55.0, 60.0)
    assert encode_state(again) == encode_state(state)
