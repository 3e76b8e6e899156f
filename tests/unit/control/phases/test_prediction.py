"""The model's step in a cycle, number by number: what is applied, what it takes in displacement, and what bounds it.

The rod is scripted (see `scripted_rod`); the law is the pretension's ramp, at its end within a cycle.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.probe import TAKE_UP, Probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.state import BadCycles
from tendond.schemas.messages import Mode
from tests.unit.control.phases.scripted_rod import Bench, MakeBench

WANTED = "[pretension]\ntension = 2.0\nduration = 0.01\n"
FAST = "[limits]\ntension_rate = 1e5\ndisplacement_rate = 1e3\n"
SLOW = "[limits]\ntension_rate = 1e5\ndisplacement_rate = 0.1\n"  # a millimetre a cycle
LAG = "[observer]\nlag = 0.02\n"
LACKING = math.exp(-0.5)  # of a step after a cycle of 10 ms


def tendons(*values: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([*values, *[0.0] * (4 - len(values))])


def test_the_model_takes_the_tension_that_is_applied_and_the_observers_force(bench: MakeBench) -> None:
    one = bench(WANTED + FAST)
    one.rod.base, one.rod.per_newton = tendons(0.001, -0.002), 0.003
    observer = replace(one.start.observer, force=np.array([0.1, 0.2, 0.3]), pull=np.array([1.0, 2.0, 3.0]))
    state = one.state(Mode.PRETENSION, observer=observer)
    after = one.go(state, pose=one.pose(state)).state
    ((tension, force),) = one.rod.steps
    assert tension.tolist() == [2.0, 0.0, 0.0, 0.0]
    assert force == pytest.approx(after.observer.force + after.observer.pull)
    assert np.array_equal(after.tension_estimate, tension)
    assert after.tension_command == pytest.approx(tension)
    assert after.displacement_command == pytest.approx([0.007, -0.002, 0.0, 0.0])
    assert after.displacement_estimate == pytest.approx(after.displacement_command)
    assert one.rod.elastic == [False]


def test_a_stretching_tendon_and_one_without_tension_take_their_own_displacements(bench: MakeBench) -> None:
    one = bench(f"[rod]\ntendon_stiffness = 2e4\n{WANTED}{FAST}slack = 0.002\n")
    assert one.go(one.state(Mode.PRETENSION)).state.displacement_command == pytest.approx([0.0, *[-0.002] * 3])
    assert one.rod.elastic == [True]


def test_a_lagging_actuator_is_led_so_that_it_is_a_cycle_later_where_it_should_be(bench: MakeBench) -> None:
    one = bench(WANTED + FAST + LAG)
    one.rod.per_newton = 0.001
    state = one.state(
        Mode.PRETENSION, tension_estimate=tendons(0.5), tension_command=tendons(0.5),
        displacement_estimate=tendons(0.001),
    )  # fmt: skip
    after = one.go(state).state
    assert after.tension_command[0] == pytest.approx((2.0 - LACKING * 0.5) / (1.0 - LACKING))
    assert after.tension_estimate[0] == pytest.approx(2.0)
    assert after.displacement_command[0] == pytest.approx((0.002 - LACKING * 0.001) / (1.0 - LACKING))
    assert after.displacement_estimate[0] == pytest.approx(0.002)


def test_a_lagging_tendon_that_is_commanded_slack_is_slack_below_a_millinewton(bench: MakeBench) -> None:
    one = bench(WANTED + FAST + LAG)
    above, below = 1.01e-3 / LACKING, 0.99e-3 / LACKING
    after = one.go(one.state(Mode.RELEASING, tension_estimate=tendons(above, below))).state
    assert after.tension_estimate == pytest.approx([1.01e-3, 0.0, 0.0, 0.0])
    pulled = one.state(Mode.RELEASING, tension_estimate=tendons(0.0), tension_command=tendons(0.601))
    small = one.go(pulled).state
    assert small.tension_command[0] == pytest.approx(1e-3)
    assert small.tension_estimate[0] == pytest.approx((1.0 - LACKING) * 1e-3)  # it is commanded


def test_a_tension_step_is_taken_as_far_as_its_displacement_may_go(bench: MakeBench) -> None:
    one = bench(WANTED + SLOW)
    one.rod.per_newton = 0.001
    response = one.go(one.state(Mode.PRETENSION))
    assert response.limited == ("displacement rate",)
    assert [tension[0] for tension, _ in one.rod.steps] == pytest.approx([2.0, 0.0, 1.0])
    assert response.state.tension_command[0] == pytest.approx(1.0)
    assert response.state.tension_estimate[0] == pytest.approx(1.0)
    assert response.state.displacement_command[0] == pytest.approx(0.001)
    assert response.state.bad_cycles.limited == 1


def test_both_kinds_of_limits_are_named(bench: MakeBench) -> None:
    one = bench(f"[limits]\ntension_rate = 50.0\ndisplacement_rate = 0.02\n{WANTED}")
    one.rod.per_newton = 0.001
    response = one.go(one.state(Mode.PRETENSION))
    assert response.limited == ("tension rate", "displacement rate")
    assert response.state.tension_command[0] == pytest.approx(0.2)


def test_where_even_the_present_tension_is_out_of_reach_it_is_held_and_the_model_is_not_asked_again(
    bench: MakeBench,
) -> None:
    one = bench(WANTED + SLOW)
    one.rod.base, one.rod.per_newton = tendons(0.005), 0.001
    held = tendons(1.5)
    after = one.go(one.state(Mode.PRETENSION, tension_estimate=held, tension_command=held)).state
    assert after.tension_command.tolist() == held.tolist()
    assert [tension[0] for tension, _ in one.rod.steps] == [2.0, 1.5]
    assert after.displacement_command[0] == pytest.approx(0.001)


def test_a_release_goes_on_where_the_displacement_does_not_follow(bench: MakeBench) -> None:
    one = bench(WANTED + SLOW)
    one.rod.base = tendons(-0.02)
    pulled = tendons(5.0)
    response = one.go(one.state(Mode.RELEASING, tension_estimate=pulled, tension_command=pulled))
    assert response.state.tension_command[0] == pytest.approx(4.4)
    assert response.limited == ()
    assert len(one.rod.steps) == 1
    assert response.state.release_pending
    assert response.state.displacement_command[0] == pytest.approx(-0.001)


def test_what_is_reached_of_a_step_stays_within_the_rate_of_the_command(bench: MakeBench) -> None:
    """A lagging actuator is elsewhere than commanded: a part of the way from there may be a leap of the command."""
    one = bench(f"[limits]\ntension_rate = 100.0\ndisplacement_rate = 0.1\n{WANTED}{LAG}")
    one.rod.per_newton = 0.001
    rising = one.go(one.state(Mode.PRETENSION, tension_command=tendons(3.0)))
    assert rising.limited == ("tension rate", "displacement rate")
    assert rising.state.tension_command[0] == pytest.approx(2.0)  # 3 N - 1 N
    falling = bench(f"[limits]\ntension_rate = 100.0\ndisplacement_rate = 0.1\n[pretension]\ntension = 0.0\n{LAG}")
    falling.rod.per_newton = 0.001
    state = falling.state(
        Mode.PRETENSION, tension_command=tendons(1.0), tension_estimate=tendons(5.0),
        displacement_command=tendons(0.005), displacement_estimate=tendons(0.005),
    )  # fmt: skip
    response = falling.go(state)
    assert "displacement rate" in response.limited
    assert response.state.tension_command[0] == pytest.approx(2.0)  # 1 N + 1 N


def test_a_probe_has_a_tension_rate_and_a_maximum_of_its_own_for_a_part_of_a_step(bench: MakeBench) -> None:
    one = bench("[limits]\ntension_rate = 100.0\ndisplacement_rate = 0.1\n", probe=True)
    probe = Probe(Phase.PULL, base=(0.0, 0.0, 0.5), model_base=(0.0, 0.0, 0.5), displacement=((0.0,) * 4, ()))
    one.rod.per_newton = 0.01
    pulled = tendons(0.5)
    response = one.go(one.state(Mode.PROBE, probe=probe, tension_command=pulled, tension_estimate=pulled))
    assert response.state.tension_command[0] < 0.5
    assert response.state.mode is Mode.PROBE


def test_a_tendon_that_is_released_in_part_of_a_step_ends_slack(bench: MakeBench) -> None:
    one = bench(WANTED + SLOW)
    one.rod.per_newton = 0.001
    pulled = tendons(0.0, 0.0018, 0.0022)
    response = one.go(one.state(Mode.PRETENSION, tension_estimate=pulled, tension_command=pulled))
    assert response.state.tension_command == pytest.approx([1.0, 0.0, 0.0011, 0.0])


def test_a_step_without_solution_is_tried_without_the_observers_pull(bench: MakeBench) -> None:
    one = bench(WANTED + FAST)
    one.rod.failures = 1
    observer = replace(one.start.observer, force=np.array([0.1, 0.2, 0.3]))
    state = one.state(Mode.PRETENSION, observer=observer, bad_cycles=BadCycles(solver_failures=2))
    response = one.go(state, pose=one.pose(state, 0.001))
    (_, first), (_, second) = one.rod.steps
    assert first == pytest.approx(response.state.observer.force + response.state.observer.pull)
    assert second == pytest.approx(response.state.observer.force)
    assert second != pytest.approx(first)
    assert response.error == ""
    assert response.state.bad_cycles.solver_failures == 0


@pytest.mark.parametrize("mode", [Mode.PRETENSION, Mode.TRACKING])
def test_without_a_solution_an_active_arm_holds_its_displacement(bench: MakeBench, mode: Mode) -> None:
    one = bench(f"{WANTED}{FAST}slack = 0.002\n")
    one.rod.failures = 2
    held = tendons(0.004, -0.003)
    pulled = tendons(1.0)
    state = one.state(
        mode, displacement_estimate=held, displacement_command=held, tension_estimate=pulled, tension_command=pulled,
        bad_cycles=BadCycles(solver_failures=2),
    )  # fmt: skip
    response = one.go(state)
    assert response.error.startswith("a time step did not converge")
    assert response.state.bad_cycles.solver_failures == 3
    assert response.state.rod is state.rod
    assert response.state.displacement_command == pytest.approx(held)


def test_without_a_solution_a_released_arm_releases_in_proportion_to_its_tension(bench: MakeBench) -> None:
    one = bench(f"{WANTED}{FAST}slack = 0.002\n")
    held, pulled = tendons(0.004, -0.003, 0.002), tendons(3.0, 1.0)
    state = one.state(
        Mode.FAULT, displacement_estimate=held, displacement_command=held, tension_estimate=pulled,
        tension_command=pulled,
    )  # fmt: skip
    one.rod.failures = 2
    after = one.go(state).state  # 2.4 and 0.4 of 3 and 1 N are left
    assert after.displacement_command == pytest.approx([0.0028, -0.003, 0.0014, 0.0])
    one.rod.failures = 2
    slack = one.go(replace_tension(state, 0.0)).state
    assert slack.displacement_command == pytest.approx([0.0, -0.003, 0.0, 0.0])
    one.rod.failures = 2
    weak = one.go(replace_tension(state, 0.8)).state  # 0.2 of 0.8 N
    assert weak.displacement_command == pytest.approx([0.001, -0.003, 0.0005, 0.0])


def replace_tension(state: Any, tension: float) -> Any:
    return replace(state, tension_estimate=tendons(tension), tension_command=tendons(tension))


@pytest.mark.parametrize("mode", [Mode.PRETENSION, Mode.RELEASING])
def test_a_displacement_that_is_no_number_is_a_fault_without_any_tension(bench: MakeBench, mode: Mode) -> None:
    one = bench(WANTED + FAST)
    one.rod.base = tendons(0.01, math.nan)
    pulled = tendons(3.0)
    response = one.go(one.state(mode, tension_estimate=pulled, tension_command=pulled, tick=9))
    after = response.state
    assert (after.mode, after.reason, after.mode_since, after.tick) == (Mode.FAULT, "the command was not finite", 9, 10)
    for values in (
        after.tension_command, after.tension_estimate, after.displacement_command, after.displacement_estimate,
    ):  # fmt: skip
        assert values.tolist() == [0.0] * 4
    assert response.command.tension == response.command.displacement == (0.0,) * 4


def probing(one: Bench, probe: Probe, **changes: Any) -> Any:
    return one.go(one.state(Mode.PROBE, probe=probe, **changes)).state


@pytest.mark.parametrize("lag", ["", LAG])
def test_a_probe_begins_at_the_reported_displacement_and_only_releases(bench: MakeBench, lag: str) -> None:
    one = bench(f"[limits]\ntension_rate = 1e5\ndisplacement_rate = 1e3\n{lag}", probe=True)
    slow, lacking = one.setup.probe.rate * one.period, LACKING if lag else 0.0
    one.rod.base = tendons(0.004, -0.004)
    held = (0.003, 0.003, -0.01, 0.0)
    first = probing(one, Probe(Phase.REST, held=held))
    expected = np.array(held) - slow
    assert first.displacement_command == pytest.approx(expected)
    assert first.displacement_estimate == pytest.approx(expected + lacking * (np.array(held) - expected))
    last = tendons(0.001, 0.001)
    second = probing(one, Probe(Phase.REST, since=1, held=held), displacement_command=last)
    assert second.displacement_command == pytest.approx(last + np.array([slow, -slow, -slow, -slow]))
    without = probing(one, Probe(Phase.REST))
    assert without.displacement_command == pytest.approx(one.rod.base - slow)


def test_a_probe_releases_what_is_not_pulled_by_its_own_slack_or_a_larger_configured_one(bench: MakeBench) -> None:
    one = bench(FAST, probe=True)
    slack, slow = one.setup.probe.slack, one.setup.probe.rate * one.period
    near = np.full(4, -slack + 0.5 * slow)
    rested = probing(one, Probe(Phase.REST, since=5), displacement_command=near)
    assert rested.displacement_command == pytest.approx([-slack] * 4)
    wide = bench(f"{FAST}slack = 0.04\n", probe=True)
    rested = probing(wide, Probe(Phase.REST, since=5), displacement_command=np.full(4, -0.04 + 0.5 * slow))
    assert rested.displacement_command == pytest.approx([-0.04] * 4)


def test_a_probed_tendon_is_taken_up_slowly_and_released_at_the_displacements_rate(bench: MakeBench) -> None:
    one = bench("[limits]\ntension_rate = 1e5\ndisplacement_rate = 0.3\n", probe=True)
    slow = one.setup.probe.rate * one.period
    one.rod.base = tendons(0.02, -0.02)
    probe = Probe(
        Phase.PULL, since=one.setup.probe.start + one.setup.probe.ramp, base=(0.0, 0.0, 0.5),
        model_base=(0.0, 0.0, 0.5), displacement=((0.0,) * 4, ()),
    )  # fmt: skip
    after = probing(one, probe, tension_command=one.setup.probe.tensions * tendons(1.0), tension_estimate=tendons(0.5))
    assert after.displacement_command[:2] == pytest.approx([TAKE_UP * slow, -0.003])
