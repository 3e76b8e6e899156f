"""The model's step without a solution or beyond numbers: what is held, what is released."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tendond.daemon.control.state import BadCycles
from tendond.schemas.messages import Mode
from tests.unit.control.phases.scripted_rod import MakeBench

WANTED = "[pretension]\ntension = 2.0\nduration = 0.01\n"
FAST = "[limits]\ntension_rate = 1e5\ndisplacement_rate = 1e3\n"


def tendons(*values: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array([*values, *[0.0] * (4 - len(values))])


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
