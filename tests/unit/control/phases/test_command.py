"""A cycle's command and its release, number by number; the rod is scripted."""

from dataclasses import replace

import numpy as np
import pytest

from tendond.daemon.control.commissioning.probe import Probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.cycle import step
from tendond.daemon.control.state import BadCycles
from tendond.schemas.base import SCHEMA_VERSION
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleInputs
from tendond.schemas.requests import ControlAction
from tests.unit.control.phases.scripted_rod import MakeBench

PULLING = np.array([2.0, 0.0, 0.0, 0.0])


def test_a_command_bears_the_cycles_number_the_poses_number_and_no_stamp(bench: MakeBench) -> None:
    one = bench()
    command = one.go(one.state(tick=41)).command
    assert (command.version, command.seq, command.pose_seq, command.stamp_ns, command.source) == (
        SCHEMA_VERSION, 41, 7, 0, "",
    )  # fmt: skip
    assert one.go(one.state(tick=41, pose=None, pose_age=None, mode=Mode.IDLE)).command.pose_seq is None


@pytest.mark.parametrize("mode", tuple(Mode))
def test_a_command_is_armed_while_active_or_releasing_and_in_a_fault_as_long_as_something_pulls(
    bench: MakeBench, mode: Mode
) -> None:
    one = bench()
    one.rod.base = np.array([0.001, -0.001, 0.0, 0.0])
    probe = Probe(Phase.PULL, base=(0.0, 0.0, 0.5), model_base=(0.0, 0.0, 0.5), displacement=((0.0,) * 4, ()))
    response = one.go(one.state(mode, tension_command=PULLING, tension_estimate=PULLING, probe=probe))
    after = response.state
    assert after.mode in (mode, Mode.IDLE)
    armed = mode in (Mode.PROBE, Mode.PRETENSION, Mode.TRACKING, Mode.RELEASING, Mode.FAULT)
    assert response.command.armed is armed
    assert response.command.tension == tuple(after.tension_command.tolist())
    assert response.command.displacement == (tuple(after.displacement_command.tolist()) if armed else (0.0,) * 4)
    assert any(after.displacement_command)


def test_in_a_fault_the_torque_is_off_once_nothing_pulls_and_at_once_where_the_wiring_is_wrong(
    bench: MakeBench,
) -> None:
    one = bench("[limits]\nrelease_rate = 60.0\ndisplacement_rate = 0.1\n")
    pulling = np.array([0.0, 0.6001, 0.0, 0.0])
    assert one.go(one.state(Mode.FAULT, tension_command=pulling)).command.armed
    assert not one.go(one.state(Mode.FAULT, tension_command=np.array([0.0, 0.5999, 0.0, 0.0]))).command.armed
    long = np.full(4, 0.01)  # 10 mm to release at 1 mm a cycle
    released = one.go(one.state(Mode.FAULT, displacement_command=long, displacement_estimate=long))
    assert released.state.release_pending
    assert released.command.armed
    assert released.command.displacement == pytest.approx((0.009,) * 4)
    for verdict, armed in (("tendon 0 is another", False), ("", True)):
        wrong = one.state(
            Mode.FAULT, displacement_command=long, displacement_estimate=long, probe=Probe(Phase.DONE, verdict=verdict)
        )
        assert one.go(wrong).command.armed is armed


def test_a_release_is_pending_where_the_rate_holds_the_displacement_back_in_a_mode_that_is_not_active(
    bench: MakeBench,
) -> None:
    one = bench("[limits]\ndisplacement_rate = 0.1\n")
    long = np.full(4, 0.01)
    for mode, pending in ((Mode.RELEASING, True), (Mode.FAULT, True), (Mode.TRACKING, False)):
        state = one.state(mode, displacement_command=long, displacement_estimate=long, tension_command=PULLING)
        assert one.go(state).state.release_pending is pending
    assert not one.go(one.state(Mode.RELEASING, tension_command=PULLING)).state.release_pending


def test_tensions_are_released_at_the_release_rate_down_to_nothing(bench: MakeBench) -> None:
    one = bench("[limits]\nrelease_rate = 30.0\n")
    tension = np.array([2.0, 0.3001, 0.2999, 0.0])
    for mode in (Mode.RELEASING, Mode.FAULT, Mode.IDLE):
        response = one.go(one.state(mode, tension_command=tension, tension_estimate=tension))
        assert response.state.tension_command == pytest.approx([1.7, 0.0001, 0.0, 0.0])
        assert response.limited == ()


def test_a_start_is_idle_and_a_request_gets_its_reply_in_its_cycle(bench: MakeBench) -> None:
    one = bench()
    first = one.go(one.state(Mode.STARTING, tick=3))
    assert (first.state.mode, first.state.reason, first.state.mode_since) == (Mode.IDLE, "started", 3)
    assert (first.reply.accepted, first.reply.text) == (False, "")
    pulling = one.state(tick=5, tension_command=PULLING, tension_estimate=PULLING)
    asked = one.go(pulling, request=ControlAction.STOP)
    assert (asked.reply.accepted, asked.state.mode, asked.state.reason) == (True, Mode.RELEASING, "asked to stop")
    _, command, record = step(one.setup, pulling, CycleInputs(request=ControlAction.STOP))
    assert (record.accepted, record.mode, record.command) == (True, Mode.RELEASING, command)
    assert record.tick == 5


def test_a_limit_that_holds_the_command_back_counts_its_cycles_and_the_minimum_does_not(bench: MakeBench) -> None:
    one = bench("[limits]\ntension_min = 0.5\ntension_rate = 1000.0\n[pretension]\ntension = 2.0\nduration = 0.01\n")
    state = one.state(Mode.PRETENSION, bad_cycles=BadCycles(limited=3))
    low = one.go(state)
    assert low.limited == ("tension min",)
    assert low.state.bad_cycles.limited == 0
    fast = bench("[limits]\ntension_rate = 10.0\n[pretension]\ntension = 2.0\nduration = 0.01\n")
    response = fast.go(fast.state(Mode.PRETENSION, bad_cycles=BadCycles(limited=3)))
    assert response.limited == ("tension rate",)
    assert response.state.bad_cycles.limited == 4
    assert response.state.tension_command[0] == pytest.approx(0.1)


def test_the_next_cycle_begins_with_the_models_new_tip_and_number(bench: MakeBench) -> None:
    one = bench()
    state = one.state(tick=12)
    marker = replace(one.start.tip, velocity=np.array([1.0, 2.0, 3.0]))
    one.monkeypatch.setattr(one.setup.rod, "tip", lambda rod: marker if rod is not state.rod else None)
    after = one.go(state).state
    assert after.tip is marker
    assert after.rod is not state.rod
    assert after.tick == 13
