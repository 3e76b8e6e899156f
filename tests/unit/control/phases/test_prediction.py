"""The model's step in a cycle, number by number: what is applied, what it takes in displacement, and what bounds it.

The rod is scripted (see `scripted_rod`); the law is the pretension's ramp, at its end within a cycle.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.commissioning.probe import Probe
from tendond.daemon.control.commissioning.probe_plan import Phase
from tendond.daemon.control.setup import CycleSetup
from tendond.model.estimation.observer import ObserverState
from tendond.schemas.config.commissioning import CommissioningSection
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection
from tendond.schemas.messages import Mode
from tests.unit.control.phases.scripted_rod import MakeBench

WANTED = "[pretension]\ntension = 2.0\nduration = 0.01\n"
FAST = "[limits]\ntension_rate = 1e5\ndisplacement_rate = 1e3\n"
SLOW = "[limits]\ntension_rate = 1e5\ndisplacement_rate = 0.1\n"  # a millimetre a cycle
LAG = "[observer]\nlag = 0.02\n"
LAG_FACTOR = math.exp(-0.5)  # of a step after a cycle of 10 ms


def tendons(*values: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([*values, *[0.0] * (4 - len(values))])


def test_the_model_takes_the_tension_that_is_applied_and_the_observers_force(bench: MakeBench) -> None:
    one = bench(WANTED + FAST)
    one.rod.base, one.rod.per_newton = tendons(0.001, -0.002), 0.003
    assert isinstance(one.start.observer, ObserverState)
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
    assert after.tension_command[0] == pytest.approx((2.0 - LAG_FACTOR * 0.5) / (1.0 - LAG_FACTOR))
    assert after.tension_estimate[0] == pytest.approx(2.0)
    assert after.displacement_command[0] == pytest.approx((0.002 - LAG_FACTOR * 0.001) / (1.0 - LAG_FACTOR))
    assert after.displacement_estimate[0] == pytest.approx(0.002)


def test_a_lagging_tendon_that_is_commanded_slack_is_slack_below_a_millinewton(bench: MakeBench) -> None:
    one = bench(WANTED + FAST + LAG)
    above, below = 1.01e-3 / LAG_FACTOR, 0.99e-3 / LAG_FACTOR
    after = one.go(one.state(Mode.RELEASING, tension_estimate=tendons(above, below))).state
    assert after.tension_estimate == pytest.approx([1.01e-3, 0.0, 0.0, 0.0])
    pulled = one.state(Mode.RELEASING, tension_estimate=tendons(0.0), tension_command=tendons(0.601))
    small = one.go(pulled).state
    assert small.tension_command[0] == pytest.approx(1e-3)
    assert small.tension_estimate[0] == pytest.approx((1.0 - LAG_FACTOR) * 1e-3)  # it is commanded


@pytest.mark.parametrize(("changes", "factor"), [({}, 1.0), ({"radius": 2e-3}, 16.0), ({"length": 1.0}, 0.5)])
def test_the_tension_that_counts_as_slack_bends_every_robot_by_the_same_angle(
    changes: dict[str, float], factor: float
) -> None:
    """Bend T r L/EI: a millinewton on the paper's robot; EI grows with the fourth power of the radius."""
    rod = RodSection(**changes)
    config = RigConfig(rod=rod, commissioning=CommissioningSection(rest=False), reference=ReferenceSection(across=0.05))
    assert CycleSetup.from_config(config).slack == pytest.approx(1e-3 * factor)


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
    """A lagging actuator is elsewhere than commanded: part of the distance from there may be a leap of the command."""
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
